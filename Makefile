# SPDX-License-Identifier: MIT
# isoshade: make demo, make check; make help lists the rest.
#
#   config=release (default) | avx2 | debug | sanitize | fuzz | coverage | threads      objects under build/$(config)
#   WERROR=-Werror      warnings stop the build, as in our own checks (make check)
#   PREFIX=/usr/local   where make install puts things; DESTDIR= is put before it, for packagers
#   SETUP=no            make demo and make check install nothing: what they need is there

config ?= release
build := build/$(config)

# ---- what it stands on: Debian packages -----------------------------------
packages := gcc g++ pkg-config libjansson-dev libpopt-dev libpng-dev libtiff-dev zlib1g-dev \
	libdeflate-dev libarchive-dev libxxhash-dev libxml2-dev libteem-dev libnifti-dev libopenexr-dev libepoxy-dev libegl-dev \
	libegl1 libgl1-mesa-dri libopenvdb-dev libnanovdb-dev libnanovdb-tools libboost-dev libcmocka-dev \
	libopenmpi-dev openmpi-bin libinsighttoolkit5-dev libhdf5-dev libnetcdf-dev libblosc-dev libzstd-dev \
	groff-base blender povray gnuplot-nox poppler-utils python3-openvdb python3-numpy mricron-data chromium \
	teem-apps libtiff-tools python3-tifffile python3-mrcfile python3-pydicom dcmtk libopenjp2-tools python3-nibabel \
	python3-vtk9 python3-h5py python3-netcdf4 python3-zarr minc-tools libopenvdb-tools clang libomp-dev cppcheck valgrind strace \
	python3-openimageio openimageio-tools python3-png

# The rooms that meet files of strangers and other programs.
strangers := base image volume

# ---- compilers -------------------------------------------------------------
CC := gcc
CXX := g++
warnings := -Wall -Wextra -Wpedantic -Wshadow -Wvla -Wpointer-arith -Wno-psabi $(WERROR)
flags_release := -O3 -march=x86-64-v2 -g -ffp-contract=off -fno-math-errno -fno-trapping-math
# Copies into buffers whose size the compiler knows stop the program where they would leave them: in all that is installed
# but the inner loops of these rooms, which copy words of fixed sizes and would call a function for each.
inner_loops := encode gradient render/cpu
fortified := -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3
# Addresses that nobody can foresee, and no table of functions that can be written once the program runs.
link_release := -pie -Wl,-z,relro,-z,now
# What was reached is written by processes that end at once, too (tests/fuzz/drive.c).
link_coverage := -Wl,-u,__gcov_dump
# The kernels without AVX-512, to measure on a machine that has it.
flags_avx2 := $(flags_release) -DISO_WITHOUT_AVX512
flags_debug := -O0 -g
# Without where each variable is at each place: the kernels of the CPU ray caster are too large for that, which gcc tells.
# What a new texture holds is no number, so that reading what nobody wrote shows.
flags_sanitize := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer \
	-fno-var-tracking-assignments -DISO_POISON_TEXTURES
# By clang, for `make fuzz`; by gcc, for the lines that fuzzing reaches.
flags_fuzz := -O1 -g -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
flags_coverage := -O1 -g --coverage
# By clang, whose OpenMP library tells the sanitizer what it waits for; gcc's does not.
flags_threads := -O1 -g -fsanitize=thread
# -fPIC for the shared library. Its functions call each other as in the program: nobody may put others in their place.
flags := $(flags_$(config)) -fPIC -fno-semantic-interposition -fopenmp -MMD -MP -Isrc -Iexporters -I.
# Those that Debian describes to pkg-config; teem, nifti and OpenVDB it does not. libarchive's description asks for packages
# of its own libraries when a program is linked with libisoshade.a.
library_pkgs := jansson libxml-2.0 libpng libtiff-4 zlib libdeflate OpenEXR Imath epoxy egl libxxhash
pkgs := $(library_pkgs) popt
pkg_cflags := $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(pkgs) 2>/dev/null)) -isystem /usr/include/nifti
pkg_libs := $(shell pkg-config --libs $(pkgs) 2>/dev/null)
missing = $(error Debian packages are missing that isoshade is built with: `make setup` installs them)
CFLAGS = -std=c11 $(warnings) -Wstrict-prototypes -Wmissing-prototypes $(flags) $(if $(pkg_libs),$(pkg_cflags),$(missing))
CXXFLAGS = -std=c++17 -Wall -Wextra $(WERROR) $(flags) $(pkg_cflags)
unpackaged_libs := -lteem -lniftiio -lznz -larchive
LDLIBS = $(unpackaged_libs) $(pkg_libs) -lstdc++ -lm
openvdb_libs = -fopenmp -lopenvdb $(shell pkg-config --libs tbb Imath libdeflate)

# ---- files -----------------------------------------------------------------
# The library is what others link with; the rooms that only commands need stand beside it, in an archive of their own.
command_rooms := atlas bench chart cli figure options report validate view
all_c := $(filter-out src/base/mpi/%,$(wildcard src/*.c src/*/*.c src/*/*/*.c exporters/*/*.c))
commands_c := $(filter $(command_rooms:%=src/%/%),$(all_c))
lab_c := $(filter src/lab/%,$(all_c))
lib_c := $(filter-out $(commands_c) $(lab_c),$(all_c))
# OpenVDB takes longer to load than all else: what stands on it is loaded when files of grids are written or read.
openvdb_cc := $(wildcard exporters/vdb/*.cc)
openvdb_o := $(openvdb_cc:%.cc=$(build)/%.o)
openvdb_library := $(build)/isoshade_openvdb.so
lab_o := $(patsubst %.c,$(build)/%.o,$(filter-out src/lab/main.c,$(lab_c)))
# OpenEXR's C library decodes some forms wrongly (src/image/exr_codec.h).
lib_cc := $(wildcard src/image/*.cc)
lib_o := $(lib_c:%.c=$(build)/%.o) $(lib_cc:%.cc=$(build)/%.o)
commands_o := $(patsubst %.c,$(build)/%.o,$(filter-out src/cli/main.c,$(commands_c)))
lib := $(build)/libisoshade.a
commands := $(build)/libcommands.a
program := $(build)/isoshade
# Research: the papers' tables and figures, rival methods, experiments. Not installed.
lab_program := $(build)/isoshade-lab

# The version stands in the header. Programs ask for the library by its major number (its soname).
version_of = $(shell sed -n 's/^.define ISO_VERSION_$(1) \([0-9]*\)$$/\1/p' src/isoshade.h)
version_major := $(call version_of,MAJOR)
version := $(version_major).$(call version_of,MINOR).$(call version_of,PATCH)
soname := libisoshade.so.$(version_major)
# Not with the sanitizers, whose runtime belongs to the program.
shared := $(if $(filter sanitize,$(config)),,$(build)/$(soname))
# Loaded when mpirun starts the program; left out where MPI is not installed.
mpi_library := $(if $(shell pkg-config --exists ompi-c && echo yes),$(build)/isoshade_mpi.so)
# Started when a file is of a format that ITK reads; left out where ITK is not installed, whose files have its version in
# their names.
itk := $(notdir $(lastword $(sort $(wildcard /usr/include/ITK-*))))
itk_program := $(if $(itk),$(build)/isoshade-itk)
itk_parts := Common IOImageBase IOPNG IOJPEG IOTIFF
# Started for HDF5, netCDF, MINC and OME-Zarr.
array_pkgs := hdf5-serial netcdf blosc libzstd jansson zlib
# A file of its own describes HDF5's high-level library since HDF5 2; before, it lies beside the other.
hdf5_hl := $(or $(shell pkg-config --silence-errors --libs hdf5_serial_hl),-lhdf5_hl)
arrays_program := $(if $(shell pkg-config --exists $(array_pkgs) && echo yes),$(build)/isoshade-arrays)
vdb_program := $(if $(wildcard src/volume/vdb/vdb_read.cc),$(build)/isoshade-vdb)
reader_programs := $(itk_program) $(arrays_program) $(vdb_program)
beside := $(openvdb_library) $(mpi_library) $(reader_programs)
test_c := $(wildcard tests/test_*.c tests/lab/test_*.c)
# The tests of src/lab lie among the others: each finds the libraries that lie next to the program.
lab_tests := $(patsubst tests/lab/%.c,$(build)/tests/%,$(filter tests/lab/%,$(test_c)))
tests := $(patsubst tests/%.c,$(build)/tests/%,$(filter-out tests/lab/%,$(test_c))) $(lab_tests)
# Readers on damaged files: targets and a driver with mutations of its own, for `make check`.
fuzz_c := $(filter-out tests/fuzz/libfuzzer.c,$(wildcard tests/fuzz/*.c))
fuzz := $(build)/isoshade-fuzz
# The same, with the reader of one of these programs within it: without a program started for each input.
fuzz_programs := $(reader_programs:$(build)/isoshade-%=$(build)/isoshade-fuzz-%)
libfuzzer_c := $(filter-out tests/fuzz/drive.c,$(wildcard tests/fuzz/*.c))
libfuzzer := $(build)/isoshade-libfuzzer
threads_program := $(build)/isoshade-threads
embedded := src/brick/warp_map.h src/encode/code_decode.h $(wildcard src/render/gl/shaders/* src/*/*.glsl \
	$(foreach suffix,html js css gp py,src/*/*.$(suffix)) exporters/*/*.py exporters/*/*.inc)

.PHONY: all setup demo check test help clean
.DEFAULT_GOAL := all

all: $(program) $(shared) $(beside) ## build the program (config=debug and others: see the head of the Makefile)
	@[ "$$(readlink isoshade)" = $(program) ] || ln -sfn $(program) isoshade

lab: all $(lab_program) ## build isoshade-lab, which reproduces papers and experiments
	@[ "$$(readlink isoshade-lab)" = $(lab_program) ] || ln -sfn $(lab_program) isoshade-lab
.PHONY: lab

help: ## this list
	@awk -F':.*## ' '/^[a-z-]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' Makefile

# ---- setup: a stamp, so that a second run does nothing ---------------------
stamp := build/.packages-$(shell echo $(packages) | cksum | cut -d' ' -f1)
setup: $(stamp) ## install the Debian packages that are missing
$(stamp):
	@mkdir -p build
	@sh tests/install-packages.sh $(packages)
	@touch $@

again := $(MAKE) --no-print-directory -j$(shell nproc)

# demo and check install what they need, unless SETUP=no.
needs_setup := $(if $(filter no,$(SETUP)),,setup)

# The compiler itself may come from setup, so the real work is a second make.
demo: $(needs_setup) ## build, take a real volume and validate it: the main job
	@$(again) all
	@sh refscenes/demo.sh

check: $(needs_setup) ## build and run all tests, under the sanitizers too
	@$(again) config=release WERROR=-Werror all tests
	@$(again) config=sanitize WERROR=-Werror all tests
	@bash tests/run.sh build/release build/sanitize

# The add-on of Blender: one zip, for 3.4 (bl_info) and for 4.2 and later (blender_manifest.toml).
addon := $(build)/isoshade-blender-addon.zip
addon: $(addon) ## pack the add-on of Blender as a zip that Blender installs
.PHONY: addon

# Those with a reader within them are for speed: the sanitizers watch the readers as programs.
tests: $(tests) $(lab_program) $(fuzz) $(if $(filter release,$(config)),$(fuzz_programs)) $(openvdb_library) ## build the test programs
.PHONY: tests
# FIGURES="hero sheet" draws these alone, FIGURES=quick those that take minutes; refscenes/figures.sh has the names.
figures: $(needs_setup) ## draw the pictures of the documentation again
	@$(again) all
	@sh refscenes/figures.sh $(FIGURES)
.PHONY: figures
reference: ## write the pages of doc/reference that are made from the program
	@$(again) all
	@python3 tests/reference_pages.py $(program) . doc/reference
.PHONY: reference
test: all tests ## build and run the tests of this config only
	@bash tests/run.sh $(build)

# WORDS="statistics" plants only those whose names hold the words.
mutants: $(needs_setup) ## are mistakes planted in the verdict's code noticed by the tests? Takes most of an hour
	@bash tests/mutants.sh $(WORDS)
.PHONY: mutants

# FAULTS="--only build" for some of the commands alone; each script's head has its options.
faults: $(needs_setup) ## does each call that fails, and each kill, end well? Takes most of an hour
	@$(again) all
	@bash tests/faults.sh $(FAULTS)
.PHONY: faults
# FUZZ="nrrd scene" takes these readers alone, FUZZ_SECONDS=3600 an hour for each; what was found stays in build/fuzzed.
FUZZ_SECONDS ?= 60
fuzz: $(needs_setup) ## damaged files for each reader, for FUZZ_SECONDS each: by clang's libFuzzer where it is installed
	@bash tests/fuzz/run.sh "$(FUZZ_SECONDS)" $(FUZZ)
fuzz-coverage: $(needs_setup) ## lines of each reader that its seeds, the corpus of `make fuzz` and mutations reach
	@$(again) config=coverage build/coverage/isoshade-fuzz fuzz-programs
	@bash tests/fuzz/coverage.sh $(FUZZ)
fuzz-programs: $(fuzz_programs)
.PHONY: fuzz fuzz-coverage fuzz-programs

threads: $(needs_setup) ## what works with several threads, under clang's sanitizer of threads
	@$(again) config=threads CC=clang build/threads/isoshade-threads
	@bash tests/threads/run.sh build/threads/isoshade-threads
.PHONY: threads

# clang's analyzer, a list of findings for each file, which is made anew when the file's object is. Files of strangers and
# other programs first: `make check` looks at these. It follows ways through a function until it has seen so many states;
# ANALYZE_NODES=225000 is what clang does unless it is told, in about five times the time.
ANALYZE_NODES ?= 20000
analyzed_in := build/analyzed/$(ANALYZE_NODES)
analyzed := $(all_c:%.c=$(analyzed_in)/%.txt)
analyze: $(analyzed) ## what clang's analyzer and cppcheck find in all files; tests/*.supp have what is none
	@bash tests/cppcheck.sh build/cppchecked
analyze-readers: $(filter $(strangers:%=$(analyzed_in)/src/%/%),$(analyzed))
.PHONY: analyze analyze-readers
$(analyzed_in)/%.txt: %.c $(build)/%.o tests/analyze.sh tests/known.awk tests/analyzed.h tests/analyzed.supp
	$(call say,SA )bash tests/analyze.sh $< $@ -Xclang -analyzer-config -Xclang max-nodes=$(ANALYZE_NODES) $(filter-out -W% -MMD -MP,$(CFLAGS)) $(if $(filter src/base/status.c,$<),,-include tests/analyzed.h)

# ---- install ---------------------------------------------------------------
PREFIX ?= /usr/local
to := $(DESTDIR)$(PREFIX)
renderers := tests/peers/vtk.json tests/peers/render_vtk.py tests/peers/exr.py
installed := bin/isoshade lib/isoshade/isoshade_openvdb.so lib/isoshade/isoshade_mpi.so lib/isoshade/isoshade-itk lib/isoshade/isoshade-arrays lib/isoshade/isoshade-vdb \
	include/isoshade.h lib/libisoshade.a lib/libisoshade.so.$(version) \
	lib/$(soname) lib/libisoshade.so lib/pkgconfig/isoshade.pc share/man/man1/isoshade.1 \
	share/bash-completion/completions/isoshade share/zsh/site-functions/_isoshade share/doc/isoshade/LICENSE \
	share/doc/isoshade/COPYING \
	share/isoshade/isoshade-blender-addon.zip $(addprefix share/isoshade/renderers/,$(notdir $(renderers)))

install: all $(addon) ## install program, library, manual page and completions under PREFIX
	@install -d $(addprefix $(to)/,$(sort $(dir $(installed))))
	install -m 755 $(program) $(to)/bin/isoshade
	install -m 644 $(openvdb_library) $(to)/lib/isoshade/
	$(if $(mpi_library),install -m 644 $(mpi_library) $(to)/lib/isoshade/)
	install -m 755 $(itk_program) $(arrays_program) $(vdb_program) $(to)/lib/isoshade/
	install -m 644 src/isoshade.h $(to)/include/
	install -m 644 $(lib) $(to)/lib/
	install -m 644 $(shared) $(to)/lib/libisoshade.so.$(version)
	ln -sf libisoshade.so.$(version) $(to)/lib/$(soname)
	ln -sf $(soname) $(to)/lib/libisoshade.so
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@VERSION@|$(version)|' -e 's|@PKGS@|$(library_pkgs) tbb|' -e 's|@LIBS@|-Wl,-u,iso_openvdb_functions $(unpackaged_libs) -lopenvdb|' \
		src/isoshade.pc.in >$(to)/lib/pkgconfig/isoshade.pc
	$(program) help --man >$(to)/share/man/man1/isoshade.1
	$(program) completion bash >$(to)/share/bash-completion/completions/isoshade
	$(program) completion zsh >$(to)/share/zsh/site-functions/_isoshade
	install -m 644 LICENSE exporters/blender/COPYING $(to)/share/doc/isoshade/
	install -m 644 $(addon) $(to)/share/isoshade/
	install -m 644 $(renderers) $(to)/share/isoshade/renderers/

uninstall: ## remove what make install put there
	rm -f $(addprefix $(to)/,$(installed))
	@rmdir $(to)/lib/isoshade $(to)/share/doc/isoshade $(to)/share/isoshade/renderers $(to)/share/isoshade 2>/dev/null || true
.PHONY: install uninstall

format: ## lay out the C and C++ files by .clang-format
	@command -v clang-format >/dev/null || { echo "clang-format is missing; it is a Debian package" >&2; exit 1; }
	clang-format -i $(wildcard $(foreach suffix,c h cc,$(addsuffix .$(suffix),src/* src/*/* src/*/*/* exporters/*/* tests/*)))
.PHONY: format

clean: ## remove what was built
	rm -rf build/release build/avx2 build/debug build/sanitize build/fuzz build/coverage build/threads build/readers build/analyzed build/cppchecked isoshade isoshade-lab

# make V=1 shows the whole commands.
ifndef V
say = @echo "  $(1)  $@";
else
say =
endif

# ---- rules -----------------------------------------------------------------
$(program): $(build)/src/cli/main.o $(commands) $(lib)
	$(call say,LD )$(CC) $(flags_$(config)) $(link_$(config)) -fopenmp -o $@ $(filter %.o %.a,$^) $(LDLIBS)
$(lab_program): $(build)/src/lab/main.o $(lab_o) $(commands) $(lib)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $(filter %.o %.a,$^) $(LDLIBS)
$(lib): $(lib_o) $(openvdb_o)
	@rm -f $@
	$(call say,AR )ar rcs $@ $^
$(commands): $(commands_o)
	@rm -f $@
	$(call say,AR )ar rcs $@ $^
# The shared library exports the functions that its header declares, and nothing else.
$(build)/exports.map: src/isoshade.h Makefile
	@mkdir -p $(@D)
	@{ echo '{ global:'; grep -oE '\<iso_[a-z0-9_]+\(' $< | sort -u | tr '(' ';'; echo 'local: *; };'; } >$@
$(build)/$(soname): $(lib_o) $(build)/exports.map
	$(call say,LD )$(CC) -shared $(flags_$(config)) -Wl,-z,relro,-z,now -fopenmp -Wl,-soname,$(soname) -Wl,--version-script=$(build)/exports.map -Wl,-z,defs -o $@ $(lib_o) $(filter-out -lpopt,$(LDLIBS))
$(openvdb_library): $(openvdb_o)
	$(call say,VDB)$(CXX) -shared $(flags_$(config)) -Wl,-z,relro,-z,now -o $@ $^ $(openvdb_libs)
$(build)/isoshade_mpi.so: src/base/mpi/ranks_mpi.c src/base/ranks_interface.h
	@mkdir -p $(@D)
	$(call say,MPI)$(CC) -std=c11 $(warnings) -O2 $(fortified) -g -Isrc $(patsubst -I%,-isystem %,$(shell pkg-config --cflags ompi-c)) -shared -fPIC -o $@ $< $(shell pkg-config --libs ompi-c)
# Each is its own files and a main(); fuzzing takes the files alone. All configs share the objects: the sanitizers watch the
# readers as programs. ITK's headers refuse some compilers.
READER_CXX ?= $(CXX)
readers_in := build/readers
child_main := src/volume/child_main.cc
child_flags := -std=c++17 -Wall -Wextra $(WERROR) -O2 $(fortified) -g -MMD -MP -Isrc -fPIE
itk_cc := $(wildcard src/volume/itk/*.cc)
arrays_cc := $(wildcard src/volume/arrays/*.cc)
vdb_cc := $(wildcard src/volume/vdb/*.cc)
itk_flags := -isystem /usr/include/$(itk) $(addprefix -isystem ,$(lastword $(wildcard /usr/include/gdcm-*)))
arrays_flags = $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(array_pkgs)))
vdb_flags = $(pkg_cflags)
itk_libs := $(foreach part,$(itk_parts),-lITK$(part)$(itk:ITK%=%)) -lgdcmMSFF -lgdcmDSED -lgdcmCommon -lz
arrays_libs = $(shell pkg-config --libs $(array_pkgs)) $(hdf5_hl)
vdb_libs = $(openvdb_libs)
# The reader within a fuzzing program is compiled with the config's own flags, if these watch its code.
fuzzed_in := $(if $(filter release,$(config)),$(readers_in),$(build)/readers)
$(readers_in)/%.o: %.cc $(readers_in)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(READER_CXX) $(child_flags) $($(notdir $(<D))_flags) -c -o $@ $<
$(build)/readers/%.o: %.cc $(build)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) $(CXXFLAGS) $($(notdir $(<D))_flags) -c -o $@ $<
$(build)/isoshade-itk: $(itk_cc:%.cc=$(readers_in)/%.o)
$(build)/isoshade-arrays: $(arrays_cc:%.cc=$(readers_in)/%.o)
$(build)/isoshade-vdb: $(vdb_cc:%.cc=$(readers_in)/%.o)
$(reader_programs): $(build)/isoshade-%: $(child_main:%.cc=$(readers_in)/%.o)
	@mkdir -p $(@D)
	$(call say,LD )$(READER_CXX) -pie -Wl,-z,relro,-z,now -o $@ $^ $($*_libs)
# With the first day that a zip knows in place of today, so that its bytes are the same whenever it is packed.
$(addon): $(wildcard exporters/blender/addon/*.py exporters/blender/addon/*.toml) LICENSE exporters/blender/COPYING
	@rm -rf $@ $(build)/addon && mkdir -p $(build)/addon/isoshade && cp $^ $(build)/addon/isoshade/
	@TZ=UTC touch -d 1980-01-01 $(build)/addon/isoshade/* $(build)/addon/isoshade
	$(call say,ZIP)cd $(build)/addon && TZ=UTC python3 -m zipfile -c ../$(@F) isoshade
$(lab_tests): $(build)/tests/%: $(build)/tests/lab/%.o $(lab_o) $(commands) $(lib)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ -lcmocka $(LDLIBS)
$(build)/tests/%: $(build)/tests/%.o $(commands) $(lib)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ -lcmocka $(LDLIBS)
# The readers that are programs of their own lie beside it, or nothing is read of their formats.
$(fuzz): $(fuzz_c:%.c=$(build)/%.o) $(commands) $(lib) | $(reader_programs)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ $(LDLIBS)
# Without the program's malloc(), which ends it where a library of others asks in vain.
$(build)/isoshade-fuzz-itk: $(itk_cc:%.cc=$(fuzzed_in)/%.o)
$(build)/isoshade-fuzz-arrays: $(arrays_cc:%.cc=$(fuzzed_in)/%.o)
$(build)/isoshade-fuzz-vdb: $(vdb_cc:%.cc=$(fuzzed_in)/%.o)
$(build)/tests/fuzz/%-in-process.o: tests/fuzz/in_process.cc $(build)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) $(CXXFLAGS) -DFUZZ_PROGRAM='"isoshade-$*"' -c -o $@ $<
$(fuzz_programs): $(build)/isoshade-fuzz-%: $(build)/tests/fuzz/%-in-process.o $(fuzz_c:%.c=$(build)/%.o) $(filter-out $(build)/src/cli/%,$(commands_o)) $(lib) | $(reader_programs)
	$(call say,LD )$(CXX) $(flags_$(config)) $(if $(filter coverage,$(config)),$(link_coverage)) -fopenmp -o $@ $^ $($*_libs) $(LDLIBS)
# FUZZ_LIBS: archives of libraries that were built with the same flags, such as teem's.
$(libfuzzer): $(libfuzzer_c:%.c=$(build)/%.o) $(commands) $(lib) | $(reader_programs)
	$(call say,LD )$(CXX) -fsanitize=fuzzer,address,undefined -fopenmp -o $@ $^ $(FUZZ_LIBS) $(LDLIBS)
$(threads_program): $(build)/tests/threads/threads.o $(lib_o)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ -lcmocka $(LDLIBS)
# Objects follow the flags that they were compiled with.
$(build)/flags: FORCE
	@mkdir -p $(@D)
	@echo '$(flags)' | cmp -s - $@ || echo '$(flags)' >$@
$(readers_in)/flags: FORCE
	@mkdir -p $(@D)
	@echo '$(filter-out $(WERROR),$(child_flags))' | cmp -s - $@ || echo '$(filter-out $(WERROR),$(child_flags))' >$@
.PHONY: FORCE
$(build)/%.o: %.c $(build)/flags
	@mkdir -p $(@D)
	$(call say,CC )$(CC) $(CFLAGS) -c -o $@ $<
$(build)/%.o: %.cc $(build)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) $(CXXFLAGS) -c -o $@ $<
# The shaders' decoders in C: 0.5 is a float there, as in GLSL.
$(build)/src/encode/decode_float.o: CFLAGS += -fsingle-precision-constant
$(build)/src/render/cpu/cast_%.o: CFLAGS += -fsingle-precision-constant
$(build)/src/encode/encode_region48.o: CFLAGS += -ffp-contract=fast
fortified_o := $(if $(filter release,$(config)),$(filter-out $(inner_loops:%=$(build)/src/%/%.o),$(lib_o)) $(commands_o) $(lab_o) \
	$(openvdb_o) $(build)/src/cli/main.o)
$(fortified_o): CFLAGS += $(fortified)
$(fortified_o): CXXFLAGS += $(fortified)
$(fortified_o): $(build)/fortified
$(build)/fortified: FORCE
	@mkdir -p $(@D)
	@echo '$(fortified)' | cmp -s - $@ || echo '$(fortified)' >$@
# Objects that embed text files (base/embed.h) follow them.
embedders := $(shell grep -ls '^ISO_EMBED' $(all_c))
$(embedders:%.c=$(build)/%.o): $(embedded)

# Kept, though only a pattern names them. Not all targets: a new source older than the library must still be built.
.SECONDARY: $(test_c:%.c=$(build)/%.o) $(fuzz_programs:$(build)/isoshade-fuzz-%=$(build)/tests/fuzz/%-in-process.o)
-include $(lab_o:.o=.d) $(build)/src/lab/main.d $(lib_o:.o=.d) $(openvdb_o:.o=.d) $(commands_o:.o=.d) $(test_c:%.c=$(build)/%.d) $(fuzz_c:%.c=$(build)/%.d) $(build)/tests/threads/threads.d $(build)/src/cli/main.d \
	$(foreach in,$(readers_in) $(fuzzed_in),$(patsubst %.cc,$(in)/%.d,$(child_main) $(itk_cc) $(arrays_cc) $(vdb_cc))) $(wildcard $(build)/tests/fuzz/*-in-process.d)
