# What every stage of the workflow finds in its environment; sourced before each of them. The settings of the libraries' threads and
# memory cost a factor of two when they are wrong.

# several tools share one terminal: the Snakefile names a folder for their lines, and run_progress.py shows them
export NLG_PROGRESS=${NLG_PROGRESS:-off}
# stages bring their own parallelism: one BLAS thread each; OpenMP threads, where a library makes some, sleep while they wait
export OPENBLAS_NUM_THREADS=1 OMP_WAIT_POLICY=passive
# OpenBLAS 0.3.21 takes newer AVX-512 processors for Haswell and halves sgemm
if grep -qw avx512f /proc/cpuinfo 2>/dev/null; then export OPENBLAS_CORETYPE=SkylakeX; fi
# libtorch frees and takes large tensors every step: keep the pages
export GLIBC_TUNABLES=glibc.malloc.mmap_max=0:glibc.malloc.trim_threshold=4294967296

# into FILE COMMAND …: what the command prints becomes the file when the command is done, as a whole; nothing does when it fails
into() {
  local file=$1 code=0
  shift
  "$@" > "$file.unfinished" || code=$?
  if [ "$code" = 0 ]; then
    sync "$file.unfinished" && mv "$file.unfinished" "$file"
  else
    rm -f "$file.unfinished"
    return "$code"
  fi
}
