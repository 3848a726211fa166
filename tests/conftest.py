"""One thread for linear algebra: the matrices are small, and more threads only slow them down. Remembered checks are
those of these tests."""

import os
import tempfile

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"):
    os.environ.setdefault(name, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ["INFOTRAJ_CACHE"] = tempfile.mkdtemp(prefix="infotraj-tests-")
