# Set-up that nlg, pipeline.sh and test.sh share: packages, configuration, builds. Sourced; its functions run at the root of the checkout.
#
# A purpose is a word behind packages of cmake/packages.txt: `train`, `pipeline`, `package`, `tests`,
# `machines`. A bake and the viewer need none.

# Installs what is missing of the packages for these purposes, and of those without one; asks for nothing when all of it is there.
install_packages() {
  local wanted missing
  if ! command -v dpkg-query > /dev/null; then
    echo "This system has no dpkg: install the equivalents of cmake/packages.txt, then build with cmake --preset release." >&2
    return 1
  fi
  mapfile -t wanted < <(awk -v purposes=" $* " '!/^#/ && NF && ($2 == "" || index(purposes, " " $2 " ")) {print $1}' cmake/packages.txt)
  # dpkg-query names packages that it does not know on stderr, and ends with 1
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}" | sort) \
    <({ dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${wanted[@]}" 2> /dev/null || true; } | sed -n 's/^installed //p' | sort))
  [ ${#missing[@]} -gt 0 ] || return 0
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo > /dev/null || { echo "Missing packages, and neither root nor sudo to install them: ${missing[*]}" >&2; return 1; }
    as_root=(sudo)
  fi
  echo "Installing ${#missing[@]} packages: ${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"
}

# Compilers at work at once: one a core, but no more than one for every 2 GB (a file with libtorch's headers takes 1.1 GB).
build_jobs() {
  local cores memory_gb
  cores=$(nproc)
  memory_gb=$(awk '/MemTotal/ {print int($2 / 1048576)}' /proc/meminfo)
  echo $((memory_gb / 2 < cores ? (memory_gb / 2 > 0 ? memory_gb / 2 : 1) : cores))
}

# The options of CMake that purposes need.
options_for() {
  case " $* " in *" train "*) echo NLG_BUILD_TRAINING ;; esac
  case " $* " in *" tests "*) echo NLG_BUILD_TRAINING NLG_BUILD_TESTS ;; esac
}

has_option() {
  grep -qsE "^$1:BOOL=(ON|TRUE|1)$" build/release/CMakeCache.txt
}

# Whether the release build was configured for these purposes, and so their packages for compiling are there.
is_configured_for() {
  local option
  [ -f build/release/build.ninja ] || return 1
  for option in $(options_for "$@"); do has_option "$option" || return 1; done
}

# Two builds in one folder would spoil it: the second waits, and says so.
lock_build() {
  flock -n 8 || { echo "Waiting for another build in $PWD/build" >&2; flock 8; }
}

# A checkout that belongs to somebody else is used, not built.
require_writable() {
  mkdir -p build 2> /dev/null
  [ -w build ] || { echo "$PWD/build: cannot be written. NLG_BIN=FOLDER takes tools that are built" >&2; return 1; }
}

# build "PURPOSES" [TARGET ...]: configures the release build for these purposes, and for those of before; builds the targets, or all.
build() {
  local targets=() options=() option wanted
  wanted=" $(options_for "$1" | tr '\n' ' ')"
  shift
  [ $# -eq 0 ] || targets=(--target "$@")
  for option in NLG_BUILD_TRAINING NLG_BUILD_TESTS; do
    if [[ $wanted == *" $option "* ]] || has_option "$option"; then options+=("-D$option=ON"); else options+=("-D$option=OFF"); fi
  done
  require_writable
  (
    lock_build
    cmake --preset release -Wno-dev "${options[@]}" > build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }
    NINJA_STATUS="building, %f of %t files, %e s: " cmake --build --preset release --parallel "$(build_jobs)" "${targets[@]}"
  ) 8> build/.lock
}

# The same of targets that were built before: only what has changed since, and without a word.
build_again() {
  require_writable
  (
    lock_build
    cmake --build --preset release --parallel "$(build_jobs)" --target "$@" -- --quiet
  ) 8> build/.lock
}
