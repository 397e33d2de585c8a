#!/usr/bin/env bash
# The tutorial's script, in a copy with two chapters, where what installs and builds is played by small scripts.
set -euo pipefail
script=$(dirname "$(readlink -f "$0")")/../tutorial
T=$(mktemp -d "${TMPDIR:-/tmp}/tutorial_test.XXXXXX")
trap 'rm -rf "$T"' EXIT

# A path with nothing on it but what the script may take for granted, and the players.
bin=$T/bin
mkdir "$bin"
for tool in bash sh env awk cat chmod cp cut dirname echo find flock grep head id ls mkdir mktemp nproc paste \
  ln printf readlink rm rmdir sed seq sleep sort tail tee touch tr xargs; do
  ln -s "$(command -v $tool)" "$bin/$tool"
done
player() { cat >"$bin/$1"; chmod +x "$bin/$1"; }

player dpkg-query <<'SH'
#!/bin/sh
[ ! -e "$T/bare" ] || exit 1
for package in "$@"; do echo "$package installed"; done
SH
player apt-get <<'SH'
#!/bin/sh
[ ! -e "$T/gone" ] || { echo "E: Unable to locate package g++"; exit 100; }
echo "W: Failed to fetch http://deb.debian.org/debian/dists  Temporary failure resolving 'deb.debian.org'"
case "$*" in *install*) echo "E: Unable to locate package g++"; exit 100 ;; esac
SH
player apt-cache <<'SH'
#!/bin/sh
echo "  Candidate: (none)"
SH
# cmake: refuses a cache from elsewhere, as the real one does; builds programs that say how they were called;
# finds out whether it is alone.
player cmake <<'SH'
#!/bin/sh
case $1 in
  --version) echo "cmake version $(cat "$T/version")" ;;
  --preset)
    [ ! -e "$T/broken" ] || { echo "-- on the way"; echo "CMake Error at CMakeLists.txt:1: $(cat "$T/broken")"; exit 1; }
    ! grep -q HOME build/CMakeCache.txt 2>/dev/null || grep -qx "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" build/CMakeCache.txt ||
      { echo "CMake Error: The current CMakeCache.txt directory is different"; exit 1; }
    mkdir -p build/CMakeFiles build/bin
    printf 'CMAKE_HOME_DIRECTORY:INTERNAL=%s\nglfw3_DIR:PATH=/lib\n' "$PWD" >build/CMakeCache.txt ;;
  --build)
    mkdir "$T/building" || touch "$T/not_alone"
    while [ -e "$T/held" ]; do sleep 0.05; done
    [ ! -e "$T/errors" ] || { rmdir "$T/building"; seq 1 100000 | sed 's/$/ error/'; exit 2; }
    for chapter in 01_first 02_second documents; do
      { echo '#!/bin/sh'
        echo 'echo "Title of it: rk4"; echo "error against the exact answer, at the end"; echo "  position  1e-09 m"'
        echo 'echo "  energy error  2e-08 J"; echo "in $PWD: $*"'
        echo 'while [ $# -gt 0 ]; do [ "$1" != --out ] || { mkdir -p "$2" && echo >"$2/scene.png"; }; shift; done'
      } >build/bin/$chapter
      chmod +x build/bin/$chapter
    done
    echo "[100%] Built"
    rmdir "$T/building" ;;
esac
SH
export T PATH=$bin
echo 3.25.1 >"$T/version"
mkdir -p "$T/home/chapters/01_first/snapshots" "$T/home/chapters/02_second" "$T/elsewhere"
cp "$script" "$T/home/tutorial"

faults=0
# expect STATUS TEXT COMMAND...: the command ends with STATUS, and says TEXT.
expect() {
  local status=0 said
  said=$("${@:3}" 2>&1 </dev/null) || status=$?
  [ $status = "$1" ] && grep -qF -- "$2" <<<"$said" && return
  printf 'wanted status %s and "%s", got %s and:\n%s\nfrom: %s\n' "$1" "$2" $status "$said" "${*:3}"
  faults=$((faults + 1))
}
tree() { (cd "$T/home" && find . -path ./build -prune -o -print | sort); }
before=$(tree)

cd "$T/home"
expect 2 "unknown command 'dance'" ./tutorial dance
expect 2 "no chapter '3'" ./tutorial run 3
expect 2 "unknown option '--x'" ./tutorial docs --x
expect 2 "./tutorial run 1 --x0 30" ./tutorial run --x0 30
expect 2 "./tutorial run 1 --x0 30" ./tutorial run 1 2 --x0 30
expect 2 "live shows one chapter" ./tutorial live
expect 0 "usage: ./tutorial" ./tutorial run --help

# Options, and paths as the caller sees them.
cd "$T/elsewhere"
expect 0 "in $T/elsewhere: run --x0 -30 --csv a.csv" ../home/tutorial run 1 --x0 -30 --csv a.csv
expect 0 "in $T/elsewhere: live --step 0.1" ../home/tutorial live 01_first --step 0.1
expect 0 "in $T/elsewhere: snapshot --at 1,2 --out $T/home/build/pictures/02_second" ../home/tutorial snapshot 2 --at 1,2
expect 0 "in $T/elsewhere: snapshot --out here" ../home/tutorial snapshot 2 --out here
expect 0 "in $T/elsewhere: report --out=here" ../home/tutorial report 2 --out=here
[ "$(../home/tutorial run 1 --csv - 2>/dev/null | tail -n 1)" = "in $T/elsewhere: run --csv -" ] ||
  expect 0 "nothing but the program on standard output" false
ln -s ../home/tutorial linked
expect 0 "in $T/elsewhere: run --x0 1" ./linked run 1 --x0 1

# Nothing is written outside build/.
cd "$T/home"
expect 0 "run" ./tutorial run 1
expect 0 "2 Title of it" ./tutorial run
for command in snapshot report stability; do
  expect 0 "$command --out build/" ./tutorial $command
  expect 0 "$command --out build/" ./tutorial $command 1
done
for file in pictures/01_first reports/02_second stability/02_second; do expect 0 "scene.png" ls build/$file; done
[ "$(tree)" = "$before" ] || expect 0 "the tree as it was" tree

# The lessons' own pictures are renewed by those who keep them.
expect 2 "lessons dance: allowed are" ./tutorial lessons dance
expect 0 "in $T/home: . build/bin" ./tutorial lessons snapshot stability
expect 0 "scene.png" ls chapters/01_first/snapshots chapters/02_second/snapshots

# A copied folder is built anew, and what the reader keeps in it stays.
echo mine >build/trajectory.csv
cp -r "$T/home" "$T/copy"
cd "$T/copy"
expect 0 "run --x0 2" ./tutorial run 1 --x0 2
expect 0 mine cat build/trajectory.csv

# Two at once: the second says that it waits, and does. The first is held until then, however slow the machine is.
cd "$T/home"
touch "$T/held"
./tutorial run 1 >"$T/first" 2>&1 &
until [ -e "$T/building" ]; do sleep 0.05; done
./tutorial run 2 >"$T/second" 2>&1 &
for _ in {1..1200}; do
  ! grep -qsF "waiting for it" "$T/second" || break
  sleep 0.05
done
rm "$T/held"
wait
expect 0 "waiting for it" cat "$T/second"
expect 0 "in $T/home: run" cat "$T/second"
[ ! -e "$T/not_alone" ] || expect 0 "one at a time" ls "$T/not_alone"

# What goes wrong says why.
echo "no such command" >"$T/broken"
expect 1 "CMake Error at CMakeLists.txt:1" ./tutorial run 1
said=$(./tutorial run 1 2>&1 || true)
case $said in *Debian* | *'on the way'*) expect 1 "CMake's error alone" ./tutorial run 1 ;; esac
echo "Could not find a package configuration file provided by Eigen3" >"$T/broken"
expect 1 "needed is what these Debian packages hold: g++" ./tutorial run 1
rm "$T/broken"
touch "$T/errors"
expect 1 "the build failed; all of it is in $T/home/build/build.log" ./tutorial run 1
rm "$T/errors"
echo 3.20.3 >"$T/version"
expect 1 "needed is CMake 3.22 or newer, as in Debian 12 and Ubuntu 22.04; here it is 3.20.3" ./tutorial run 1
touch "$T/bare"
player id <<<'#!/bin/sh
echo 1000'
expect 1 "as root: apt-get update && apt-get install --no-install-recommends g++" ./tutorial run 1
player sudo <<'SH'
#!/bin/sh
[ "$1" = -v ] || exec "$@"
SH
expect 1 "Temporary failure resolving" ./tutorial run 1
player id <<<'#!/bin/sh
echo 0'
expect 1 "Temporary failure resolving" ./tutorial run 1
said=$(./tutorial run 1 2>&1 || true)
case $said in *Unable*) expect 1 "the cause alone" ./tutorial run 1 ;; esac

touch "$T/gone"
expect 1 "Unable to locate package g++" ./tutorial run 1

[ $faults = 0 ] && echo "all as expected"
exit $((faults > 0))
