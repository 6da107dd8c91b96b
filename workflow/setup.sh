# Set-up that pipeline.sh and test.sh share: packages, configuration. Sourced from the root of the checkout.

# Installs what is missing from cmake/packages.txt; asks for nothing when all of it is there. With `tests`: what the suite needs, too.
install_packages() {
  local missing=() package purpose
  if ! command -v dpkg-query > /dev/null; then
    echo "This system has no dpkg: install the equivalents of cmake/packages.txt, then call cmake and snakemake as README.md shows." >&2
    return 1
  fi
  while read -r package purpose; do
    [ -z "$purpose" ] || [ "$purpose" = "${1:-}" ] || continue
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2> /dev/null || true)" = installed ] || missing+=("$package")
  done < <(grep -v '^#' cmake/packages.txt)
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

# Configures the release build and builds the targets named, or everything.
build() {
  local targets=()
  [ $# -eq 0 ] || targets=(--target "$@")
  cmake --preset release -Wno-dev > build/configure.log 2>&1 || { cat build/configure.log >&2; return 1; }
  cmake --build --preset release --parallel "$(build_jobs)" "${targets[@]}"
}
