#!/usr/bin/env bash
# Takes the library home: builds it in the folder WORK and a project that uses it, with warnings as errors.
#
#   take_home_test.sh page | folder WORK CMAKE [LIBRARY]
#
# page: installed, by the very commands of docs/your_own_scene.md, all but those that install packages. What
#   they would compile first, LIBRARY is already: made of the same sources with the same flags.
# folder: by add_subdirectory and by FetchContent, as a shared library.
set -euo pipefail
way=$1 work=$2 cmake=$3 library=${4-}
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# A build type that adds no flags; Debug would do, but takes longer.
export CXXFLAGS="${CXXFLAGS-} -Wall -Wextra -Wpedantic -Werror" CMAKE_BUILD_TYPE=None
die() { echo "$*" >&2; exit 1; }
cmake() {
  case $1 in
    # All sources of a target in one piece: what they have in common, most of Eigen, is compiled once.
    -S) command "$cmake" "$@" -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 ;;
    --build)
      [[ $2 == build/library && $library ]] || { command "$cmake" "$@"; return; }
      cp "$library" build/library/common/mechanics ;;
    *) command "$cmake" "$@" ;;
  esac
}

# right TABLE: the rocker stands where Freudenstein's equation puts it, and the energy is the torque's work.
right() {
  awk 'NR > 1 { n += ($4 ^ 2 < 1e-24) && ($5 ^ 2 < 1e-6) } END { exit n != NR - 1 || n != 9 }' "$1" ||
    { cat "$1"; die "not the four-bar's motion"; }
}

rm -rf "$work"
mkdir -p "$work"
cd "$work"

if [ "$way" = page ]; then
  for entry in "$source"/*; do  # the tutorial, with a build folder of its own
    [[ ${entry##*/} == build* ]] || ln -s "$entry" .
  done
  # shellcheck disable=SC2016
  sed -n '/^```sh$/,/^```$/{ /^```/d; /apt-get/d; p }; /^## .*chapter/q' docs/your_own_scene.md >commands
  grep -q 'cmake --install' commands || die "the page does not say how to install"
  # shellcheck source=/dev/null
  . ./commands | tee output
  grep -A 9 't \[s\]' output >table
  right table
  packages=$(grep -o '^.*_DIR:PATH' build/library/CMakeCache.txt)
  [ "$packages" = Eigen3_DIR:PATH ] || die "asked for more than Eigen: $packages"

  cd build/taken_home/include/constrained_dynamics
  find . -name '*.hpp' -exec grep -hE '^ *# *include' {} + | sed 's/.*[<"]\(.*\)[">].*/\1/' | sort -u | while read -r name; do
    [[ -f $name || $name == Eigen/* || $name =~ ^[a-z_]+$ ]] || die "an installed header includes $name"
  done
  exit
fi

for way in add_subdirectory FetchContent; do
  cmake -S "$source/tests/take_home" -B build -DWAY=$way -DLIBRARY="$source" -DBUILD_SHARED_LIBS=ON
  cmake --build build -j 2
  [ "$(cd build && ctest -N | grep -c '^ *Test *#')" = 1 ] || die "the library brings tests along"
  build/four_bar | tee table
  right table
done
