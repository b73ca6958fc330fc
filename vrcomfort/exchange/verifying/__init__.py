"""Whether a study folder is whole: files, rows, ids and times that agree, checksums."""

from vrcomfort.exchange.verifying.findings import Finding, Verified
from vrcomfort.exchange.verifying.study import verify_study

__all__ = ["Finding", "Verified", "verify_study"]
