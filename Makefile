# SPDX-License-Identifier: MIT
# isoshade: make demo, make check; make help lists the rest.
#
#   config=release (default) | avx2 | debug | sanitize | fuzz | coverage | threads      objects go to build/$(config)
#   WERROR=-Werror      warnings stop the build, as in make check
#   PREFIX=/usr/local   folder for make install; packagers set DESTDIR=, which is put before it
#   SETUP=no            make demo and make check install no packages
#   REPRODUCIBLE=yes    equal bits from each folder of the sources, for packages

config ?= release
build := build/$(config)

# Builds use all cores unless -j says otherwise. Other targets start builds of their own.
ifeq ($(filter-out all lab tests,$(MAKECMDGOALS))$(filter -j% --jobserver%,$(MAKEFLAGS)),)
MAKEFLAGS += -j$(shell nproc)
endif

# ---- Debian packages -------------------------------------------------------
# For the program and a first picture. Each library that is missing otherwise costs its own feature.
packages := gcc g++ pkg-config libjansson-dev libpopt-dev libpng-dev libtiff-dev zlib1g-dev libdeflate-dev libarchive-dev \
	libxxhash-dev libxml2-dev libteem-dev libnifti-dev libopenexr-dev liblz4-dev liblzma-dev mricron-data
# For OpenGL, OpenVDB and the other renderers: make demo.
demo_packages := $(packages) libepoxy-dev libegl-dev libegl1 libgl1-mesa-dri libopenvdb-dev libnanovdb-dev libboost-dev \
	blender povray gnuplot-nox
# For all formats and the tests: make check.
check_packages := $(demo_packages) libnanovdb-tools libcmocka-dev libopenmpi-dev openmpi-bin libinsighttoolkit5-dev \
	libhdf5-dev libnetcdf-dev libblosc-dev groff-base poppler-utils python3-openvdb python3-numpy chromium \
	python3-yaml teem-apps libtiff-tools python3-tifffile python3-mrcfile python3-pydicom dcmtk libopenjp2-tools \
	python3-nibabel python3-astropy python3-vtk9 python3-h5py python3-netcdf4 python3-zarr minc-tools libopenvdb-tools \
	clang libomp-dev cppcheck valgrind strace python3-venv python3-openimageio openimageio-tools python3-png xvfb xauth

# Folders that parse untrusted input.
untrusted := base image volume

# ---- compilers -------------------------------------------------------------
CC := gcc
CXX := g++
OBJCOPY := objcopy
warnings := -Wall -Wextra -Wpedantic -Wshadow -Wvla -Wpointer-arith -Wno-psabi $(WERROR)
# SSE4.2 on PCs; kernels for later processors are chosen at run time. gcc 12 for arm64 ends with an internal error at
# maxima in loops.
compiler := $(shell $(CC) -dumpmachine 2>/dev/null)-$(shell $(CC) -dumpversion 2>/dev/null)
baseline := $(if $(filter x86_64-%,$(compiler)),-march=x86-64-v2)
baseline := $(or $(baseline),$(if $(filter aarch64-%-12,$(compiler)),-fno-tree-loop-vectorize))
flags_release := -O3 $(baseline) -g -ffp-contract=off -fno-math-errno -fno-trapping-math
# Check copies into buffers of known size at run time, in all that is installed. Not in the inner loops of these folders:
# each copy of a fixed-size word would become a function call.
inner_loops := encode gradient render/cpu
fortified := -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3
# PIE (ASLR) and full RELRO.
link_release := -pie -Wl,-z,relro,-z,now
# Processes that end at once write their coverage, too (tests/fuzz/drive.c).
link_coverage := -Wl,-u,__gcov_dump
# Kernels without AVX-512, for measurements on a machine that has it.
flags_avx2 := $(flags_release) -DISO_WITHOUT_AVX512
flags_debug := -O0 -g
# No variable tracking: gcc warns that kernels of the CPU ray caster are too large. New textures are filled with NaN, so
# that reads of unwritten texels are visible.
flags_sanitize := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer \
	-fno-var-tracking-assignments -DISO_POISON_TEXTURES
# fuzz: clang, for `make fuzz`; coverage: gcc, for the lines that fuzzing reaches.
flags_fuzz := -O1 -g -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
flags_coverage := -O1 -g --coverage
# clang only: its OpenMP library reports its synchronization to the sanitizer; gcc's does not.
flags_threads := -O1 -g -fsanitize=thread
# -fPIC is for the shared library. Its functions call each other directly: other libraries cannot replace them.
flags := $(flags_$(config)) -fPIC -fno-semantic-interposition -fopenmp -MMD -MP -Isrc -Iexporters -I.
any_folder := $(if $(REPRODUCIBLE),-ffile-prefix-map=$(CURDIR)=.)
# Packages with a pkg-config file; teem, nifti and OpenVDB have none. libarchive's would require further packages when a
# program is linked with libisoshade.a.
PKG_CONFIG ?= pkg-config
has_pkgs = $(shell $(PKG_CONFIG) --exists $(1) 2>/dev/null && echo yes)
has_gl := $(call has_pkgs,epoxy egl)
library_pkgs := jansson libxml-2.0 libpng libtiff-4 zlib libdeflate OpenEXR Imath libxxhash $(if $(has_gl),epoxy egl)
pkgs := $(library_pkgs) popt
pkg_cflags := $(patsubst -I%,-isystem %,$(shell $(PKG_CONFIG) --cflags $(pkgs) 2>/dev/null)) -isystem /usr/include/nifti
pkg_libs := $(shell $(PKG_CONFIG) --libs $(pkgs) 2>/dev/null)
unpackaged := teem/nrrd.h nifti/nifti1_io.h archive.h lz4.h lzma.h
has_all := $(and $(pkg_libs),$(filter $(words $(unpackaged)),$(words $(wildcard $(unpackaged:%=/usr/include/%)))))
missing = $(error Debian packages are missing; install them with `make setup`: $(shell sh tests/install-packages.sh --missing $(packages)))
CFLAGS = -std=c11 $(warnings) -Wstrict-prototypes -Wmissing-prototypes $(flags) $(any_folder) $(if $(has_all),$(pkg_cflags),$(missing))
CXXFLAGS = -std=c++17 -Wall -Wextra $(WERROR) $(flags) $(any_folder) $(pkg_cflags)
unpackaged_libs := -lteem -lniftiio -lznz -larchive -llz4 -llzma
LDLIBS = $(unpackaged_libs) $(pkg_libs) -lstdc++ -lm
has_openvdb := $(and $(wildcard /usr/include/openvdb/openvdb.h),$(wildcard /usr/include/nanovdb/*),$(call has_pkgs,tbb))
openvdb_libs := $(if $(has_openvdb),-fopenmp -lopenvdb $(shell $(PKG_CONFIG) --libs tbb Imath libdeflate))

# ---- files -----------------------------------------------------------------
# Other programs link with the library. Folders that only commands need go into a separate archive.
command_folders := atlas bench chart cli figure options report validate
all_c := $(filter-out src/base/mpi/% $(if $(has_gl),src/render/no_gl.c,src/render/gl/%),$(wildcard src/*.c src/*/*.c src/*/*/*.c exporters/*/*.c))
commands_c := $(filter $(command_folders:%=src/%/%),$(all_c))
lab_c := $(filter src/lab/%,$(all_c))
lib_c := $(filter-out $(commands_c) $(lab_c),$(all_c))
# OpenVDB loads slowly, so code that uses it is loaded only to read or write grid files; skipped if it is not installed.
openvdb_cc := $(if $(has_openvdb),$(wildcard exporters/vdb/*.cc))
openvdb_o := $(openvdb_cc:%.cc=$(build)/%.o)
openvdb_library := $(if $(has_openvdb),$(build)/isoshade_openvdb.so)
lab_o := $(patsubst %.c,$(build)/%.o,$(filter-out src/lab/main.c,$(lab_c)))
# OpenEXR's C library decodes some forms wrongly (src/image/exr_codec.h).
lib_cc := $(wildcard src/image/*.cc)
lib_o := $(lib_c:%.c=$(build)/%.o) $(lib_cc:%.cc=$(build)/%.o)
commands_o := $(patsubst %.c,$(build)/%.o,$(filter-out src/cli/main.c,$(commands_c)))
lib := $(build)/libisoshade.a
archive := $(build)/installed/libisoshade.a
commands := $(build)/libcommands.a
program := $(build)/isoshade
# Research: the papers' tables and figures, other methods, experiments. Not installed.
lab_program := $(build)/isoshade-lab

# The version comes from the header. Programs load the library by its major number (soname).
version_of = $(shell sed -n 's/^.define ISO_VERSION_$(1) \([0-9]*\)$$/\1/p' src/isoshade.h)
version_major := $(call version_of,MAJOR)
version := $(version_major).$(call version_of,MINOR).$(call version_of,PATCH)
soname := libisoshade.so.$(version_major)
# No shared library with sanitizers: their runtime belongs to the program.
shared := $(if $(filter sanitize,$(config)),,$(build)/$(soname))
# Loaded when mpirun starts the program; skipped if MPI is not installed.
mpi_library := $(if $(call has_pkgs,ompi-c),$(build)/isoshade_mpi.so)
# Reads ITK's formats; skipped if ITK is not installed. The names of ITK's files contain its version.
itk := $(notdir $(lastword $(sort $(wildcard /usr/include/ITK-*))))
itk_program := $(if $(itk),$(build)/isoshade-itk)
itk_parts := Common IOImageBase IOPNG IOJPEG IOTIFF
# Reads HDF5, netCDF, MINC and OME-Zarr.
array_pkgs := hdf5-serial netcdf libarchive blosc liblz4 jansson zlib
# HDF5's high-level library has its own pkg-config file since HDF5 2; earlier it is next to the main library.
hdf5_hl := $(or $(shell $(PKG_CONFIG) --libs hdf5_serial_hl 2>/dev/null),-lhdf5_hl)
arrays_program := $(if $(call has_pkgs,$(array_pkgs)),$(build)/isoshade-arrays)
vdb_program := $(if $(has_openvdb),$(build)/isoshade-vdb)
reader_programs := $(itk_program) $(arrays_program) $(vdb_program)
beside := $(openvdb_library) $(mpi_library) $(reader_programs)
# The lab reads no untrusted input, and its tests compute for long: the sanitizers leave it out.
with_lab := $(if $(filter sanitize,$(config)),,lab)
test_c := $(wildcard tests/test_*.c $(with_lab:%=tests/%/test_*.c))
# Programs of tests/lab go to the same folder as other tests: they find libraries by their path from the program.
lab_tests := $(patsubst tests/lab/%.c,$(build)/tests/%,$(filter tests/lab/%,$(test_c)))
tests := $(patsubst tests/%.c,$(build)/tests/%,$(filter-out tests/lab/%,$(test_c))) $(lab_tests)
# Tests of the product that plant the lab's faults, or read grid files back as the lab does.
helped_tests := $(addprefix $(build)/tests/test_,calibrate limits bake planned scaled_render vdb vdb_sparse)
helpers_o := $(addprefix $(build)/src/lab/,faults.o ray_faults.o vdb_read.o)
# Fuzzing for `make check`: targets, and a driver that mutates files itself.
fuzz_c := $(filter-out tests/fuzz/libfuzzer.c,$(wildcard tests/fuzz/*.c))
fuzz := $(build)/isoshade-fuzz
# The same with a reader linked in, so that no program is started per input.
fuzz_programs := $(reader_programs:$(build)/isoshade-%=$(build)/isoshade-fuzz-%)
libfuzzer_c := $(filter-out tests/fuzz/drive.c,$(wildcard tests/fuzz/*.c))
libfuzzer := $(build)/isoshade-libfuzzer
threads_program := $(build)/isoshade-threads
embedded := src/encode/code_decode.h $(wildcard src/render/gl/shaders/* src/*/*.glsl \
	$(foreach suffix,html js css gp py,src/*/*.$(suffix)) exporters/*/*.py exporters/*/*.inc)

.PHONY: all setup demo check test help clean
.DEFAULT_GOAL := all

all: $(program) $(shared) $(beside) ## build the program (config=debug and others: see the head of the Makefile)
	@[ "$$(readlink isoshade)" = $(program) ] || ln -sfn $(program) isoshade

lab: $(if $(has_gl),all $(lab_program),no-lab) ## build isoshade-lab, which reproduces papers and experiments
	@[ "$$(readlink isoshade-lab)" = $(lab_program) ] || ln -sfn $(lab_program) isoshade-lab
no-lab:
	@echo 'isoshade-lab needs OpenGL: install the Debian packages libepoxy-dev and libegl-dev' >&2; exit 1
.PHONY: lab no-lab

help: ## show this list
	@awk -F':.*## ' '/^[a-z-]+:.*## / {printf "  make %-13s %s\n", $$1, $$2}' Makefile

# ---- setup: a stamp file per list makes a second run do nothing ------------
setup_packages := $(packages)
stamp = build/.packages-$(shell echo $($(1)_packages) | cksum | cut -d' ' -f1)
setup: $(call stamp,setup) ## install the Debian packages for the program and a first picture
setup-demo: $(call stamp,demo) ## ... and for OpenGL, OpenVDB, Blender and POV-Ray
setup-check: $(call stamp,check) ## ... and for all formats and the tests
$(foreach list,setup demo check,$(eval $(call stamp,$(list)): install_packages := $($(list)_packages)))
build/.packages-%:
	@mkdir -p build
	@sh tests/install-packages.sh $(install_packages)
	@touch $@
.PHONY: setup-demo setup-check

again := $(MAKE) --no-print-directory -j$(shell nproc)

# demo, check and others install missing packages, unless SETUP=no.
needs_setup := $(if $(filter no,$(SETUP)),,setup-check)

# setup may install the compiler itself, so a second make does the work.
demo: $(needs_setup:setup-check=setup-demo) ## build, and validate a real volume: the main job
	@$(again) all
	@sh refscenes/demo.sh

# FIDELITY_DATA=DIR: real volumes, for three more scenes.
fidelity: $(needs_setup) ## compare all renderers of this machine, and make build/fidelity/site of certificates
	@$(again) all
	@bash tests/peers/fidelity.sh $(FIDELITY_DATA)
.PHONY: fidelity

check: $(needs_setup) ## build and run all tests, also with sanitizers
	@$(again) config=release WERROR=-Werror all tests
	@$(again) config=sanitize WERROR=-Werror all tests
	@bash tests/run.sh build/release build/sanitize

# Debian packages, from a copy of the sources: dpkg-buildpackage writes next to its folder.
deb_folder := build/deb/isoshade-$(version)
deb: ## build Debian packages in build/deb
	@command -v dh dh_python3 dpkg-buildpackage >/dev/null || { echo "make deb needs the Debian packages build-essential, debhelper and dh-python" >&2; exit 1; }
	@rm -rf build/deb && mkdir -p $(deb_folder)
	@tar -c --exclude=./build --exclude-vcs . | tar -x -C $(deb_folder)
	cd $(deb_folder) && unset MAKEFLAGS MFLAGS && dpkg-buildpackage -b -us -uc
	@rm -r $(deb_folder)
wheel: all ## build a Python wheel with the library in build/wheel; other libraries stay Debian's
	@python3 python/wheel.py $(shared) build/wheel
sbom: all ## write build/isoshade.spdx.json: the Debian packages of the libraries that the built files load
	@python3 tests/sbom.py $(version) build/isoshade.spdx.json $(program) $(shared) $(beside)
RELEASE ?= bookworm
deb-check: ## build, install, use and purge the packages in clean Debians, as root: RELEASE=trixie
	@bash tests/packages.sh $(RELEASE)
.PHONY: deb wheel sbom deb-check

# The Blender add-on: one zip, for 3.4 (bl_info) and for 4.2 and later (blender_manifest.toml).
addon := $(build)/isoshade-blender-addon.zip
addon: $(addon) ## pack the Blender add-on as a zip
.PHONY: addon

# Fuzzing programs with a reader linked in are only for speed: under sanitizers, readers run as programs.
tests: $(tests) $(if $(with_lab),$(lab_program)) $(fuzz) $(if $(filter release,$(config)),$(fuzz_programs)) $(openvdb_library) ## build the test programs
.PHONY: tests
# FIGURES="hero sheet" draws only these, FIGURES=quick all that take minutes; refscenes/figures.sh has the names.
figures: $(needs_setup) ## redraw the pictures of the documentation
	@$(again) all
	@sh refscenes/figures.sh $(FIGURES)
.PHONY: figures
reference: ## write the generated pages of doc/reference
	@$(again) all
	@python3 tests/reference_pages.py $(program) . doc/reference
.PHONY: reference
test: all tests ## build and run the tests of this config
	@bash tests/run.sh $(build)

# WORDS="statistics" plants only mutants with these words in their names.
mutants: $(needs_setup) ## check that tests find faults planted in the verdict's code (most of an hour)
	@bash tests/mutants.sh $(WORDS)
.PHONY: mutants

# FAULTS="--only build" tests some commands only; the head of each script lists its options.
faults: $(needs_setup) ## check the end of the program after failing calls and signals (most of an hour)
	@$(again) all
	@bash tests/faults.sh $(FAULTS)
.PHONY: faults
# FUZZ="nrrd scene" tests only these readers, FUZZ_SECONDS=3600 an hour each; findings stay in build/fuzzed.
FUZZ_SECONDS ?= 60
fuzz: $(needs_setup) ## test each reader with damaged files for FUZZ_SECONDS, with clang's libFuzzer if installed
	@bash tests/fuzz/run.sh "$(FUZZ_SECONDS)" $(FUZZ)
fuzz-coverage: $(needs_setup) ## list lines of readers that seeds, the corpus of `make fuzz` and mutations reach
	@$(again) config=coverage build/coverage/isoshade-fuzz fuzz-programs
	@bash tests/fuzz/coverage.sh $(FUZZ)
fuzz-programs: $(fuzz_programs)
.PHONY: fuzz fuzz-coverage fuzz-programs

threads: $(needs_setup) ## test multithreaded code with clang's thread sanitizer
	@$(again) config=threads CC=clang build/threads/isoshade-threads
	@bash tests/threads/run.sh build/threads/isoshade-threads
.PHONY: threads

# Findings of clang's analyzer per file, updated with the file's object. `make check` covers the folders that parse
# untrusted input. The analyzer follows paths through a function up to this many states; clang's default, 225000, takes
# about five times as long.
ANALYZE_NODES ?= 20000
analyzed_in := build/analyzed/$(ANALYZE_NODES)
analyzed := $(all_c:%.c=$(analyzed_in)/%.txt)
analyze: $(analyzed) ## run clang's analyzer and cppcheck on all files; tests/*.supp list false findings
	@bash tests/cppcheck.sh build/cppchecked
analyze-readers: $(filter $(untrusted:%=$(analyzed_in)/src/%/%),$(analyzed))
.PHONY: analyze analyze-readers
$(analyzed_in)/%.txt: %.c $(build)/%.o tests/analyze.sh tests/known.awk tests/analyzed.h tests/analyzed.supp
	$(call say,SA )bash tests/analyze.sh $< $@ -Xclang -analyzer-config -Xclang max-nodes=$(ANALYZE_NODES) $(filter-out -W% -MMD -MP,$(CFLAGS)) $(if $(filter src/base/status.c,$<),,-include tests/analyzed.h)

# ---- install ---------------------------------------------------------------
PREFIX ?= /usr/local
# Debian's packages have lib/x86_64-linux-gnu: libraries, and the modules and programs that isoshade loads and starts.
libdir ?= lib
to := $(DESTDIR)$(PREFIX)
renderers := tests/peers/vtk.json tests/peers/render_vtk.py tests/peers/exr.py
# Where Python searches: Debian's packages, /usr/local, and virtual environments or ~/.local.
python_version := $(shell python3 -c 'import sys; print("python%d.%d" % sys.version_info[:2])' 2>/dev/null)
python_dir := lib/$(if $(filter /usr,$(PREFIX)),python3/dist-packages,$(python_version)/$(if $(filter /usr/local,$(PREFIX)),dist,site)-packages)/isoshade
python_files := $(wildcard python/isoshade/*.py python/isoshade/py.typed)
installed := bin/isoshade $(addprefix $(libdir)/isoshade/,isoshade_openvdb.so isoshade_mpi.so isoshade-itk isoshade-arrays isoshade-vdb) \
	include/isoshade.h $(libdir)/libisoshade.a $(libdir)/libisoshade.so.$(version) \
	$(libdir)/$(soname) $(libdir)/libisoshade.so $(libdir)/pkgconfig/isoshade.pc share/man/man1/isoshade.1 \
	share/bash-completion/completions/isoshade share/zsh/site-functions/_isoshade share/doc/isoshade/LICENSE \
	share/doc/isoshade/COPYING $(addprefix share/isoshade/renderers/,$(notdir $(renderers)))
# With Python only: its package, and the add-on, which Python packs.
with_python := $(addprefix $(python_dir)/,$(notdir $(python_files))) share/isoshade/isoshade-blender-addon.zip

install: all $(archive) $(if $(python_version),$(addon)) ## install program, library, manual page and completions under PREFIX
	@install -d $(addprefix $(to)/,$(sort $(dir $(installed))))
	install -m 755 $(program) $(to)/bin/isoshade
	$(if $(strip $(openvdb_library) $(mpi_library)),install -m 644 $(openvdb_library) $(mpi_library) $(to)/$(libdir)/isoshade/)
	$(if $(strip $(reader_programs)),install -m 755 $(reader_programs) $(to)/$(libdir)/isoshade/)
	install -m 644 src/isoshade.h $(to)/include/
	install -m 644 $(archive) $(to)/$(libdir)/libisoshade.a
	install -m 644 $(shared) $(to)/$(libdir)/libisoshade.so.$(version)
	ln -sf libisoshade.so.$(version) $(to)/$(libdir)/$(soname)
	ln -sf $(soname) $(to)/$(libdir)/libisoshade.so
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@LIBDIR@|$(libdir)|' -e 's|@VERSION@|$(version)|' \
		-e 's|@LIBS@|$(unpackaged_libs) $(if $(has_openvdb),-lopenvdb) $(shell $(PKG_CONFIG) --libs $(library_pkgs) $(if $(has_openvdb),tbb))|' \
		src/isoshade.pc.in >$(to)/$(libdir)/pkgconfig/isoshade.pc
	$(program) help --man >$(to)/share/man/man1/isoshade.1
	$(program) completion bash >$(to)/share/bash-completion/completions/isoshade
	$(program) completion zsh >$(to)/share/zsh/site-functions/_isoshade
	install -m 644 LICENSE exporters/blender/COPYING $(to)/share/doc/isoshade/
	install -m 644 $(renderers) $(to)/share/isoshade/renderers/
	$(if $(python_version),install -d $(to)/$(python_dir) && install -m 644 $(python_files) $(to)/$(python_dir)/ && \
		install -m 644 $(addon) $(to)/share/isoshade/)

uninstall: ## remove installed files
	rm -f $(addprefix $(to)/,$(installed) $(with_python))
	@rm -rf $(to)/$(python_dir)/__pycache__
	@rmdir $(to)/$(python_dir) $(to)/$(libdir)/isoshade $(to)/share/doc/isoshade $(to)/share/isoshade/renderers $(to)/share/isoshade 2>/dev/null || true
.PHONY: install uninstall

format: ## format the C and C++ files by .clang-format
	@command -v clang-format >/dev/null || { echo "clang-format is missing; it is a Debian package" >&2; exit 1; }
	clang-format -i $(wildcard $(foreach suffix,c h cc,$(addsuffix .$(suffix),src/* src/*/* src/*/*/* exporters/*/* tests/*)))
.PHONY: format

clean: ## remove built files
	rm -rf build/release build/avx2 build/debug build/sanitize build/fuzz build/coverage build/threads build/readers build/analyzed build/cppchecked isoshade isoshade-lab

# make V=1 shows the full commands.
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
$(lib): $(lib_o) $(openvdb_o) $(build)/parts
	@rm -f $@
	$(call say,AR )$(AR) rcs $@ $(filter %.o,$^)
$(commands): $(commands_o)
	@rm -f $@
	$(call say,AR )$(AR) rcs $@ $^
# The shared library exports only the functions of its header.
$(build)/exports.map: src/isoshade.h Makefile
	@mkdir -p $(@D)
	@{ echo 'ISOSHADE_$(version_major).$(call version_of,MINOR) { global:'; grep -oE '\<iso_[a-z0-9_]+\(' $< | sort -u | tr '(' ';'; echo 'local: *; };'; } >$@
$(build)/$(soname): $(lib_o) $(build)/exports.map $(build)/parts
	$(call say,LD )$(CC) -shared $(flags_$(config)) -Wl,-z,relro,-z,now -fopenmp -Wl,-soname,$(soname) -Wl,--version-script=$(build)/exports.map -Wl,-z,defs -o $@ $(lib_o) $(filter-out -lpopt,$(LDLIBS))
# The archive that is installed: one object, whose internal names are not visible to programs that link with it.
$(archive): $(lib) $(build)/exports.map
	@mkdir -p $(@D)
	@{ sed -n 's/;$$//p' $(build)/exports.map | grep -o 'iso_[a-z0-9_]*'; } >$(build)/exports
	$(call say,LD )$(LD) -r -o $(build)/whole.o --whole-archive $(lib)
	@$(OBJCOPY) --keep-global-symbols=$(build)/exports $(build)/whole.o
	@rm -f $@ && $(AR) rcs $@ $(build)/whole.o && rm $(build)/whole.o
$(build)/isoshade_openvdb.so: $(openvdb_o)
	$(call say,VDB)$(CXX) -shared $(flags_$(config)) -Wl,-z,relro,-z,now -o $@ $^ $(openvdb_libs)
$(build)/isoshade_mpi.so: src/base/mpi/ranks_mpi.c src/base/ranks_interface.h
	@mkdir -p $(@D)
	$(call say,MPI)$(CC) -std=c11 $(warnings) -O2 $(fortified) -g $(any_folder) -Isrc $(patsubst -I%,-isystem %,$(shell $(PKG_CONFIG) --cflags ompi-c)) -shared -fPIC -Wl,-z,relro,-z,now -o $@ $< $(shell $(PKG_CONFIG) --libs ompi-c)
# Reader programs: their own files and a shared main(), which fuzzing leaves out. All configs share the objects. ITK's
# headers refuse some compilers.
READER_CXX ?= $(CXX)
readers_in := build/readers
child_main := src/volume/child_main.cc
child_flags := -std=c++17 -Wall -Wextra $(WERROR) -O2 $(fortified) -g -MMD -MP -Isrc -fPIE
itk_cc := $(wildcard src/volume/itk/*.cc)
arrays_cc := $(wildcard src/volume/arrays/*.cc)
vdb_cc := $(wildcard src/volume/vdb/*.cc)
itk_flags := -isystem /usr/include/$(itk) $(addprefix -isystem ,$(lastword $(wildcard /usr/include/gdcm-*)))
arrays_flags = $(patsubst -I%,-isystem %,$(shell $(PKG_CONFIG) --cflags $(array_pkgs)))
vdb_flags = $(pkg_cflags)
itk_libs := $(foreach part,$(itk_parts),-lITK$(part)$(itk:ITK%=%)) -lgdcmMSFF -lgdcmDSED -lgdcmCommon -ltiff -lz
arrays_libs = $(shell $(PKG_CONFIG) --libs $(array_pkgs)) $(hdf5_hl)
vdb_libs = $(openvdb_libs)
# A reader that is linked into a fuzzing program gets the config's own flags, unless the config is release.
fuzzed_in := $(if $(filter release,$(config)),$(readers_in),$(build)/readers)
$(readers_in)/%.o: %.cc $(readers_in)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(READER_CXX) $(child_flags) $(any_folder) $($(notdir $(<D))_flags) -c -o $@ $<
$(build)/readers/%.o: %.cc $(build)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) $(CXXFLAGS) $($(notdir $(<D))_flags) -c -o $@ $<
$(build)/isoshade-itk: $(itk_cc:%.cc=$(readers_in)/%.o)
$(build)/isoshade-arrays: $(arrays_cc:%.cc=$(readers_in)/%.o)
$(build)/isoshade-vdb: $(vdb_cc:%.cc=$(readers_in)/%.o)
$(reader_programs): $(build)/isoshade-%: $(child_main:%.cc=$(readers_in)/%.o)
	@mkdir -p $(@D)
	$(call say,LD )$(READER_CXX) -pie -Wl,-z,relro,-z,now -o $@ $^ $($*_libs)
# Files get the earliest date that zip supports, so that the zip's bytes do not depend on the day. The folder's name is
# the module's in Blender before 4.2, which would find an installed Python package isoshade first.
$(addon): $(wildcard exporters/blender/addon/*.py exporters/blender/addon/*.toml) LICENSE exporters/blender/COPYING
	@rm -rf $@ $(build)/addon && mkdir -p $(build)/addon/isoshade_addon && cp $^ $(build)/addon/isoshade_addon/
	@TZ=UTC touch -d 1980-01-01 $(build)/addon/isoshade_addon/* $(build)/addon/isoshade_addon
	$(call say,ZIP)cd $(build)/addon && TZ=UTC python3 -m zipfile -c ../$(@F) isoshade_addon
$(lab_tests): $(build)/tests/%: $(build)/tests/lab/%.o $(lab_o) $(commands) $(lib)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ -lcmocka $(LDLIBS)
$(helped_tests): $(build)/tests/%: $(build)/tests/%.o $(helpers_o) $(commands) $(lib)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ -lcmocka $(LDLIBS)
$(build)/tests/%: $(build)/tests/%.o $(commands) $(lib)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ -lcmocka $(LDLIBS)
# Reader programs must be in the same folder, otherwise their formats cannot be read.
$(fuzz): $(fuzz_c:%.c=$(build)/%.o) $(commands) $(lib) | $(reader_programs)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ $(LDLIBS)
# Without src/cli/memory.c, which ends the program if another library runs out of memory.
$(build)/isoshade-fuzz-itk: $(itk_cc:%.cc=$(fuzzed_in)/%.o)
$(build)/isoshade-fuzz-arrays: $(arrays_cc:%.cc=$(fuzzed_in)/%.o)
$(build)/isoshade-fuzz-vdb: $(vdb_cc:%.cc=$(fuzzed_in)/%.o)
$(build)/tests/fuzz/%-in-process.o: tests/fuzz/in_process.cc $(build)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) $(CXXFLAGS) -DFUZZ_PROGRAM='"isoshade-$*"' -c -o $@ $<
$(fuzz_programs): $(build)/isoshade-fuzz-%: $(build)/tests/fuzz/%-in-process.o $(fuzz_c:%.c=$(build)/%.o) $(filter-out $(build)/src/cli/%,$(commands_o)) $(lib) | $(reader_programs)
	$(call say,LD )$(CXX) $(flags_$(config)) $(if $(filter coverage,$(config)),$(link_coverage)) -fopenmp -o $@ $^ $($*_libs) $(LDLIBS)
# FUZZ_LIBS: archives of libraries built with the same flags, such as teem's.
$(libfuzzer): $(libfuzzer_c:%.c=$(build)/%.o) $(commands) $(lib) | $(reader_programs)
	$(call say,LD )$(CXX) -fsanitize=fuzzer,address,undefined -fopenmp -o $@ $^ $(FUZZ_LIBS) $(LDLIBS)
$(threads_program): $(build)/tests/threads/threads.o $(lib_o)
	$(call say,LD )$(CC) $(flags_$(config)) -fopenmp -o $@ $^ -lcmocka $(LDLIBS)
# Objects are rebuilt when their flags change.
$(build)/flags: noted = $(flags)
$(readers_in)/flags: noted = $(filter-out $(WERROR),$(child_flags))
$(build)/fortified: noted = $(fortified)
# So are the library, when its parts change, and the object that knows the folder of the modules.
$(build)/parts: noted = $(lib_o) $(openvdb_o)
$(build)/libdir: noted = $(libdir)
notes := $(build)/flags $(readers_in)/flags $(build)/fortified $(build)/parts $(build)/libdir
$(notes): FORCE
	@mkdir -p $(@D)
	@echo '$(noted)' | cmp -s - $@ || echo '$(noted)' >$@
.PHONY: FORCE
$(build)/%.o: %.c $(build)/flags
	@mkdir -p $(@D)
	$(call say,CC )$(CC) $(CFLAGS) -c -o $@ $<
$(build)/%.o: %.cc $(build)/flags
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) $(CXXFLAGS) -c -o $@ $<
# Decoders shared with the shaders: a literal such as 0.5 is a float, as in GLSL.
$(build)/src/encode/decode_float.o: CFLAGS += -fsingle-precision-constant
$(build)/src/render/cpu/cast_%.o: CFLAGS += -fsingle-precision-constant
$(build)/src/encode/encode_region48.o: CFLAGS += -ffp-contract=fast
fortified_o := $(if $(filter release,$(config)),$(filter-out $(inner_loops:%=$(build)/src/%/%.o),$(lib_o)) $(commands_o) $(lab_o) \
	$(openvdb_o) $(build)/src/cli/main.o)
$(fortified_o): CFLAGS += $(fortified)
$(fortified_o): CXXFLAGS += $(fortified)
$(fortified_o): $(build)/fortified
$(build)/src/base/helper.o $(analyzed_in)/src/base/helper.txt: CFLAGS += -DISO_LIBDIR='"../$(libdir)/isoshade"'
$(build)/src/base/helper.o: $(build)/libdir
# Tests compile in half the time, and compute little themselves.
$(test_c:%.c=$(build)/%.o): CFLAGS += $(if $(filter release,$(config)),-O1)
# Objects that embed text files (base/embed.h) depend on them.
embedders := $(shell grep -ls '^ISO_EMBED' $(all_c))
$(embedders:%.c=$(build)/%.o): $(embedded)

# Keep these objects, which only a pattern names. Not all: a new source older than the library must still be built.
.SECONDARY: $(test_c:%.c=$(build)/%.o) $(fuzz_programs:$(build)/isoshade-fuzz-%=$(build)/tests/fuzz/%-in-process.o)
-include $(lab_o:.o=.d) $(build)/src/lab/main.d $(lib_o:.o=.d) $(openvdb_o:.o=.d) $(commands_o:.o=.d) $(test_c:%.c=$(build)/%.d) $(fuzz_c:%.c=$(build)/%.d) $(build)/tests/threads/threads.d $(build)/src/cli/main.d \
	$(foreach in,$(readers_in) $(fuzzed_in),$(patsubst %.cc,$(in)/%.d,$(child_main) $(itk_cc) $(arrays_cc) $(vdb_cc))) $(wildcard $(build)/tests/fuzz/*-in-process.d)
