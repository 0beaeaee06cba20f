# SPDX-License-Identifier: MIT
# environment.sh - sourced by run.sh and lib.sh: what a caller's shell may have set and tests have to do without. The
# terminal, the language, the umask, a home folder with settings of gnuplot or MPI in it and switches of the OpenMP library
# change nothing that is tested; TMPDIR and OMP_NUM_THREADS stay as they are, and change nothing either.
export LC_ALL=C.UTF-8 TERM=dumb
umask 022
unset CDPATH BASH_ENV POSIXLY_CORRECT GREP_OPTIONS GREP_COLORS COLUMNS LINES NO_COLOR DISPLAY XDG_CONFIG_HOME XDG_CACHE_HOME
unset OMP_DYNAMIC OMP_THREAD_LIMIT OMP_MAX_ACTIVE_LEVELS OMP_PROC_BIND OMP_PLACES OMP_SCHEDULE OMP_STACKSIZE
unset GNUTERM GNUPLOT_LIB GDFONTPATH POVINI PYTHONPATH PYTHONHOME

# Threads that wait for others sleep: several tests run at a time, and one that spins takes the processor from another.
export OMP_WAIT_POLICY=passive

# What hangs is ended some day. No result hangs on it: the slowest case takes minutes on a machine that does much else.
patience=3600
patiently() { timeout $patience "$@"; }
