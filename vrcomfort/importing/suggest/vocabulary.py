"""Words by which labs call things, in the languages that we meet. Compared as `plain` writes them.

A word that is not here is no fault: it becomes a doubt in the mapping, or an ignored column.
"""

from __future__ import annotations

from collections.abc import Mapping

from vrcomfort.questionnaire.instruments import plain

_FACT_HEADINGS: Mapping[str, str] = {
    "participant": "p, participant, participant id, participantid, participant number, "
    "participant no, "
    "participant code, part id, id participant, subject, subject id, subjectid, subject number, "
    "subject no, subj, subj id, sub, sub id, pid, ppid, p id, pp, ppn, pp nr, vp, vpn, vp nr, "
    "vp code, "
    "vpnummer, vp nummer, versuchsperson, versuchspersonencode, versuchspersonennummer, proband, "
    "probanden id, probandennummer, probandencode, teilnehmer, teilnehmer id, teilnehmernummer, "
    "teilnehmercode, teilnehmer code, personencode, persönlicher code, code, user, user id, "
    "userid, "
    "username, person, "
    "person id, id, no, nr, number, nummer, case, caseid, participante, sujeto, sujet, numéro, "
    "soggetto, partecipante, deelnemer, deelnemer id, proefpersoon, uczestnik, "
    "participant identifier, "
    "respondent, respondent id, prolific id, prolific pid, subject code, identifier, anonymous id, "
    "your participant id, please enter your participant id, your id, study id",
    "condition": "condition, cond, conditions, condition name, bedingung, versuchsbedingung, "
    "treatment, condición, condicion, conditie, condizione, warunek, exp condition, "
    "experimental condition, display, display mode, technique, method, locomotion, "
    "locomotion technique, stimulus, variant, setting, mode, modus, effect, blur, fov, vignette, "
    "which condition, condition code, system",
    "timepoint": "timepoint, time point, time, phase, moment, measurement, measurement time, "
    "messzeitpunkt, zeitpunkt, zeit, pre post, prepost, when, occasion, wave, stage, "
    "administration, "
    "momento, tiempo, tijdstip, meting, test time",
    "session": "session, session id, session number, session no, sessionid, sitzung, termin, "
    "visit, "
    "day, tag, sesión, sesion, séance, sessie, sessione",
    "trial": "trial, trial number, trial no, trial id, trialnumber, run, round, runde, durchgang, "
    "exposure, exposure number, position, presentation order, condition order, order number, "
    "trial index, iteration, attempt, ronda, essai, run number, exposure no",
    "period": "period, periode",
    "block": "block, block number",
    "scene": "scene, environment, world, level, map, umgebung, szene, virtual environment, ve, "
    "scenario, game",
}

_COVARIATE_HEADINGS: Mapping[str, str] = {
    "age": "age, alter, edad, âge, leeftijd, età, idade, your age, age years, age in years, "
    "how old "
    "are you, wiek",
    "sex": "sex, geschlecht, sexo, sexe, sesso, geslacht, biological sex",
    "gender": "gender, género, genre, genere, your gender, gender identity, płeć",
    "group": "group, gruppe, groupe, grupo, gruppo, groep, cohort, study group, "
    "experimental group, "
    "grupa",
    "sequence": "sequence, order, reihenfolge, condition sequence, counterbalancing, "
    "counterbalance, order group, latin square, volgorde, ordre, orden",
    "handedness": "handedness, hand, händigkeit, dominant hand",
    "vr_experience": "vr experience, experience with vr, vr erfahrung, prior vr experience, "
    "experience, erfahrung, used vr, previous vr use, vr usage",
    "gaming": "gaming, gamer, gaming experience, games, gaming hours, spielerfahrung",
    "mssq": "mssq, mssq short, mssq score, motion sickness susceptibility, mssq total",
    "ipd_mm": "ipd, ipd mm, interpupillary distance, pupillendistanz",
    "vision": "vision, glasses, visual acuity, corrected vision, brille, sehhilfe, "
    "vision correction",
    "height": "height, height cm, größe, körpergröße",
    "status": "",
}

_METADATA_HEADINGS = (
    "timestamp, zeitstempel, start date, startdate, end date, enddate, recorded date, "
    "recordeddate, "
    "date, datum, fecha, datetime, created at, submitted at, submit date, submitdate, "
    "date submitted, date started, startdate, datestamp, last page, lastpage, start language, "
    "startlanguage, seed, refurl, ip address, ipaddress, ipaddr, status, progress, "
    "duration in seconds, duration, finished, response id, responseid, recipient last name, "
    "recipientlastname, recipient first name, recipientfirstname, recipient email, recipientemail, "
    "external reference, externalreference, externaldatareference, location latitude, "
    "locationlatitude, location longitude, locationlongitude, distribution channel, "
    "distributionchannel, user language, userlanguage, q recaptcha score, qrecaptchascore, email, "
    "email address, e mail, e mail adresse, name, first name, last name, vorname, nachname, "
    "consent, "
    "einverständnis, einwilligung, comments, comment, kommentar, kommentare, remarks, bemerkungen, "
    "notes, feedback, lfdn, external lfdn, tester, dispcode, interview time, interviewtime, "
    "lastdata, collector id, collectorid, respondent id, custom data 1"
)

_PERSONAL = ("email", "emailaddress", "name", "firstname", "lastname", "ipaddress", "ipaddr",
             "vorname", "nachname", "recipientemail", "emailadresse")  # fmt: skip


def _split(words: str) -> frozenset[str]:
    return frozenset(plain(word) for word in words.split(",") if plain(word))


FACT_HEADINGS = {fact: _split(words) for fact, words in _FACT_HEADINGS.items()}
COVARIATES = {name: _split(words) for name, words in _COVARIATE_HEADINGS.items()}
METADATA = _split(_METADATA_HEADINGS)
PERSONAL = frozenset(_PERSONAL)

_TIMEPOINTS: Mapping[str, str] = {
    "baseline": "baseline, pre, before, vorher, vor, prä, prae, pretest, pre test, pre exposure, "
    "preexposure, pre vr, prevr, before vr, before exposure, avant, antes, prima, voor, "
    "voormeting, "
    "vormessung, przed, initial, bl, base, pre immersion, preimmersion, pre ssq, prior",
    "post": "post, after, nachher, nach, posttest, post test, post exposure, postexposure, "
    "post vr, "
    "postvr, after vr, after exposure, après, apres, después, despues, dopo, na, nameting, "
    "nachmessung, po, post immersion, postimmersion, immediately after, direkt danach, danach",
    "recovery": "recovery, follow up, followup, fu, later, recovered, erholung, after rest, "
    "post2, post 2, delayed, post10, post 10 min, post 15 min, post 30 min, post30, post15, "
    "after10, "
    "30 min after, nacherhebung",
}
TIMEPOINTS = {word: name for name, words in _TIMEPOINTS.items() for word in _split(words)}
"""Word → timepoint."""

_SEVERITY = (
    # none, slight, moderate, severe
    ("none, no, not at all, absent, never, no symptom, no symptoms, nothing, nil, not present",
     "slight, slightly, mild, mildly, a little, little, low, minimal, weak, light, a bit, minor",
     "moderate, moderately, medium, mid, some, somewhat, average, middle",
     "severe, severely, strong, strongly, high, extreme, extremely, very, very much, heavy, "
     "intense, "
     "a lot"),
    ("keine, nicht, gar nicht, überhaupt nicht, kein, nein, nicht vorhanden, keines, keiner, nie",
     "leicht, gering, etwas, wenig, schwach, ein wenig, geringfügig, leichte, leichtes",
     "mittel, mäßig, mässig, moderat, mittelmäßig, mittelmässig, mittelstark, mittlere, maessig, "
     "mittelgradig",
     "stark, schwer, sehr, heftig, sehr stark, schwere, starke, ausgeprägt"),
    ("aucun, aucune, pas du tout, nul, absente, rien, non",
     "léger, légère, faible, un peu, légèrement, leger, legere",
     "modéré, modérée, moyen, moyenne, modérément, modere, moderee, moyennement",
     "sévère, severe, fort, forte, sévèrement, intense, fortement"),
    ("ninguno, ninguna, nada, ausente, en absoluto, ningún",
     "leve, ligero, ligera, poco, un poco, ligeramente",
     "moderado, moderada, medio, moderadamente, regular",
     "severo, severa, grave, fuerte, intenso, intensa, mucho"),
    ("nessuno, nessuna, assente, per niente, niente, affatto, per nulla",
     "lieve, leggero, leggera, leggermente, un po",
     "moderato, moderata, medio, media, moderatamente",
     "grave, severo, severa, forte, intenso, gravemente"),
    ("nenhum, nenhuma, nada, ausente, de modo nenhum",
     "leve, ligeiro, ligeira, pouco, levemente",
     "moderado, moderada, médio, moderadamente",
     "severo, severa, grave, forte, intenso"),
    ("geen, niet, helemaal niet, afwezig",
     "licht, lichte, mild, een beetje, gering",
     "matig, matige, gemiddeld",
     "ernstig, zwaar, hevig, sterk, ernstige, erg"),
    ("ingen, inga, inget, inte alls, ikke, slet ikke",
     "lätt, lindrig, let, lite, mild, litt, lindrigt",
     "måttlig, måttligt, moderat",
     "svår, kraftig, svær, sterk, alvorlig, svårt, kraftigt"),
    ("brak, wcale, nie", "lekki, lekkie, lekka, łagodny, słaby",
     "umiarkowany, umiarkowane, umiarkowana, średni", "silny, silne, silna, ciężki, poważny"),
    ("なし, ない, 無し, まったくない, 全くない, 感じない",
     "わずか, 少し, 軽度, やや, 少しある, わずかにある",
     "中程度, 中等度, 中くらい, 中度", "重度, ひどい, 激しい, 強い, かなり, 非常に"),
    ("无, 没有, 無, 沒有, 完全没有, 无症状", "轻微, 輕微, 轻度, 輕度, 稍微, 有点",
     "中等, 中度, 中等程度, 一般, 适中", "严重, 嚴重, 重度, 非常严重, 剧烈"),
    ("없음, 전혀 없음, 전혀없음, 없다", "약간, 경미, 조금, 경도, 약간 있음",
     "보통, 중간, 중등도, 중간 정도", "심함, 심각, 심하다, 중증, 매우 심함"),
    ("yok, hiç", "hafif, az", "orta", "şiddetli, ağır, çok"),
    ("нет, отсутствует, никакой", "слабо, легкая, лёгкая, слегка, легкий, слабая",
     "умеренно, умеренная, средне, умеренный", "сильно, сильная, тяжелая, тяжёлая, сильный"),
)  # fmt: skip
SEVERITY: dict[str, int] = {}
"""Word → 0 (none) to 3 (severe)."""
for _language in _SEVERITY:
    for _value, _words in enumerate(_language):
        for _word in _split(_words):
            SEVERITY.setdefault(_word, _value)

MISSING = frozenset(
    ["na", "n/a", "nan", "null", "nil", ".", "-", "--", "#n/a", "#null!", "missing", "k.a.",
     "k. a.", "ka", "keine angabe", "prefer not to say", "prefer not to answer", "no answer",
     "no response", "sin respuesta", "weiß nicht", "weiss nicht", "don't know", "ns/nc", "?",
     "n.a.", "not answered", "undefined", "#value!", "#div/0!"]
)  # fmt: skip
"""Texts (in small letters) that mean that there is no answer."""

TOTALS = frozenset(
    ["mean", "means", "average", "avg", "total", "totals", "sum", "sd", "std", "stdev", "n",
     "count", "median", "min", "max", "se", "sem", "mittelwert", "mw", "summe", "gesamt",
     "standardabweichung",
     "anzahl", "durchschnitt", "moyenne", "media", "promedio", "gemiddelde", "std dev", "variance",
     "grand total", "mean sd", "m", "grand mean", "standard deviation", "total general"]
)  # fmt: skip
"""Names of rows below the participants."""

LONG_ITEM = _split(
    "item, question, symptom, item name, questionnaire item, frage, variable, item id, "
    "question id, "
    "itemname, questionid, questiontext, question text, symptome, síntoma, pregunta, key, "
    "name, label"
)
LONG_RESPONSE = _split(
    "response, answer, value, rating, score, antwort, wert, responses, answers, reply, severity, "
    "respuesta, valor, réponse, antwoord, result, selected, selection, choice, response value, "
    "answer value"
)
ELAPSED_S = _split(
    "time s, times, t s, elapsed s, elapsed, seconds, sec, onset s, onset, elapsed time, "
    "time seconds, time sec, time in s, exposure time, t, zeit s, sekunden"
)

SCALE_WORDS: Mapping[str, Mapping[str, str]] = {
    "ssq": {
        "total": "T", "totalscore": "T", "ts": "T", "t": "T", "totalseverity": "T", "gesamt": "T",
        "sum": "T", "score": "T", "overall": "T", "totalssq": "T",
        "nausea": "N", "n": "N", "naus": "N", "übelkeit": "N",
        "oculomotor": "O", "o": "O", "oculomotordisturbance": "O", "okulomotorik": "O", "ocu": "O",
        "oculo": "O", "oculomotordiscomfort": "O", "oculomotorstrain": "O", "om": "O",
        "disorientation": "D", "d": "D", "diso": "D", "dis": "D", "desorientierung": "D",
    },
}  # fmt: skip
"""Instrument → word (without sum, score and the like) → scale."""
