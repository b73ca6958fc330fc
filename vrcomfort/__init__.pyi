from vrcomfort import stats as stats
from vrcomfort.api.answers import score_answers as score_answers
from vrcomfort.api.reports import load_plan as load_plan
from vrcomfort.api.reports import read_study as read_study
from vrcomfort.api.reports import write_report as write_report
from vrcomfort.api.simulation import simulate_study as simulate_study
from vrcomfort.api.views import render_views as render_views
from vrcomfort.errors import InputError as InputError
from vrcomfort.protocol import load_protocol as load_protocol

__version__: str
