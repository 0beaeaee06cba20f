#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# third_party.sh [FOLDER]: what reads NRRD and NIfTI within isoshade and is not isoshade's, teem's nrrd and libnifti, from the
# sources of the Debian packages that are installed, with clang's sanitizers and with what libFuzzer is led by. The archive is
# FOLDER/libreaders.a (build/third_party):
#
#   tests/fuzz/third_party.sh && make fuzz FUZZ_LIBS="build/third_party/libreaders.a -lbz2" FUZZ="nrrd nhdr nifti"
#
# Sources come by apt-get from a list of their own, so that the system's lists stay as they are. For another compiler than
# clang: FUZZ_CC=gcc FUZZ_FLAGS="-O1 -g -fsanitize=address,undefined".
set -eu
cd "$(dirname "$0")/../.."
folder=$(realpath -m "${1:-build/third_party}")
flags=${FUZZ_FLAGS:--O1 -g -fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer}
mkdir -p "$folder/lists/partial" "$folder/include/teem" "$folder/objects"
cd "$folder"
for tool in apt-get dpkg-source "${FUZZ_CC:-clang}"; do
    command -v "$tool" >/dev/null || { echo "third_party.sh: there is no $tool" >&2; exit 7; }
done

# ---- the sources ----
if ! ls -d teem-*/ >/dev/null 2>&1 || ! ls -d nifti*/ >/dev/null 2>&1; then
    . /etc/os-release
    # From where the system has its packages.
    mirror=$(apt-get indextargets --format '$(REPO_URI)' "Codename: $VERSION_CODENAME" 'Created-By: Packages' 'Component: main' | head -n 1)
    [ -n "$mirror" ] || { echo "third_party.sh: apt-get knows no mirror of $VERSION_CODENAME" >&2; exit 7; }
    printf 'deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main\n' "$mirror" "$VERSION_CODENAME" >sources.list
    ours=(-q -o Dir::Etc::sourcelist="$folder/sources.list" -o Dir::Etc::sourceparts=/dev/null -o Dir::State::lists="$folder/lists" -o APT::Sandbox::User=root)
    apt-get "${ours[@]}" update
    apt-get "${ours[@]}" source teem nifticlib
fi

# ---- the parts that are used ----
teem=$(ls -d teem-*/) nifti=$(ls -d nifti*/)
cp "$teem"/src/{air,hest,biff,nrrd}/*.h "$teem"/include/*.h include/teem
compile() { # NAME MORE ...: each file of stdin, as many at a time as there are cores
    local name=$1
    shift
    # shellcheck disable=SC2086 # flags are words
    xargs -P "$(nproc)" -I{} sh -c 'file=$1 object=objects/$2-$(basename "$1" .c).o; shift 2; [ "$object" -nt "$file" ] || "$@" -c "$file" -o "$object"' \
        sh {} "$name" ${FUZZ_CC:-clang} $flags -w -fPIC "$@"
}
# What teem's own configuration finds out: the order of bytes, quiet NaNs, no direct I/O.
for part in air hest biff nrrd; do
    ls "$teem/src/$part"/*.c | compile "$part" -Iinclude -Iinclude/teem -DTEEM_ENDIAN=1234 -DTEEM_QNANHIBIT=1 -DTEEM_DIO=0 -DTEEM_32BIT=0 \
        -DTEEM_ZLIB=1 -DTEEM_BZIP2=1 -DTEEM_PNG=1
done
ls "$nifti"/znzlib/znzlib.c "$nifti"/niftilib/nifti1_io.c | compile nifti -I"$nifti/znzlib" -I"$nifti/niftilib" -DHAVE_ZLIB
rm -f libreaders.a
ar crs libreaders.a objects/*.o
echo "$folder/libreaders.a: $(ls objects | wc -l) files of $teem and $nifti"
