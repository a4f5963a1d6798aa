# make demo | test | zip | docs, and test-all | test-matrix | test-mitsuba | test-window | mutants | lint | bench | report
# | held-out | evidence | contact | release
# PYTHON=python3.13 chooses the interpreter (3.11 or 3.13)

SUPPORTED := import sys; sys.exit(sys.version_info[:2] not in ((3, 11), (3, 13)))
PYTHON ?= $(shell for p in python3.11 python3.13 python3; do \
	$$p -c '$(SUPPORTED)' 2>/dev/null && echo $$p && break; done)
VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)
ENV := build/env-$(VERSION)
RUN := $(ENV)/bin/python
LINT := build/env-lint-$(VERSION)
DOCS := build/env-docs-$(VERSION)
RELEASE := $(shell sed -n 's/^version = "\(.*\)"/\1/p' blender_manifest.toml)
EXTENSION := build/measured_brdf-$(RELEASE).zip
STARTER := starter_library/starter.blend
DEBIAN := libx11-6 libxi6 libxxf86vm1 libxfixes3 libxrender1 libxkbcommon0 libsm6 libice6 libgl1 libegl1

.DELETE_ON_ERROR:
.PHONY: demo test test-all test-matrix test-mitsuba test-mitsuba-if-there test-window mutants lint \
	bench report held-out evidence zip docs contact release clean

demo: $(ENV)/ready
	$(RUN) -m demo_scenes

# what protects users; where the time goes is printed at the end
PYTEST := OPENBLAS_NUM_THREADS=1 $(RUN) -m pytest -n auto --dist loadfile -p tools.durations
test: $(ENV)/ready
	$(PYTEST) -m "not release"
	@$(RUN) -m tools.evidence --check | tail -n 1

# everything: also what only a release needs, on every supported Blender, and with each guard removed in turn
test-all: $(ENV)/ready $(STARTER)
	$(PYTEST) -p tools.reached
	$(RUN) -m tools.durations --check
	$(RUN) -m tools.test_matrix
	$(RUN) -m tools.mutants

test-matrix: $(ENV)/ready
	$(RUN) -m tools.test_matrix

# a second renderer's pictures; it needs LLVM (on Debian: apt-get install libllvm15)
test-mitsuba: $(ENV)/ready
	$(RUN) -m pip install --quiet --group mitsuba
	$(RUN) -m pytest tests/mitsuba

# the same where LLVM is, for a release, which says where it is not
test-mitsuba-if-there: $(ENV)/ready
	if /sbin/ldconfig -p | grep -q libLLVM; then $(MAKE) test-mitsuba; \
	else echo "NOT RUN: make test-mitsuba, as LLVM is not there (on Debian: apt-get install libllvm15)"; fi

# as root, on Debian: puts a Blender with a window into build/window (1.2 GB, two minutes) where none is named
WINDOW := $(or $(MEASURED_BRDF_WINDOW),build/window)
test-window: $(ENV)/ready $(STARTER)
	test -x $(WINDOW)/usr/bin/blender || bash ../shared/tools/blender_gui/setup_blender_gui.sh $(WINDOW) sid
	MEASURED_BRDF_WINDOW=$(abspath $(WINDOW)) $(RUN) -m pytest tests/window

mutants: $(ENV)/ready
	$(RUN) -m tools.mutants

lint: $(LINT)/ready
	$(LINT)/bin/python -m ruff check .
	mkdir -p build/typing && ln -sfn ../.. build/typing/measured_brdf
	$(LINT)/bin/python -m mypy

bench: $(ENV)/ready
	$(RUN) -m benchmarks

# goes on where an interrupted run of the same code stopped
held-out: $(ENV)/ready
	$(RUN) -m benchmarks.held_out --resume --out build/held_out

report: $(ENV)/ready
	$(RUN) -m benchmarks.report --out build/report

# every table, number and picture of README.md and docs/: within an hour on two idle cores
evidence: $(ENV)/ready
	$(RUN) -m tools.evidence

# all that the extension offers, as balls, with what is conspicuous in them: build/contact; hours
contact: $(ENV)/ready
	$(RUN) -m benchmarks.contact

# what is uploaded to extensions.blender.org, after all checks (docs/publishing.md): build/release
release:
	$(MAKE) -j2 --output-sync=target lint zip
	$(RUN) -m tools.evidence --check
	$(MAKE) test-all test-window test-mitsuba-if-there
	$(RUN) -m benchmarks.contact --turn $(RELEASE)
	$(RUN) tools/blender_extension.py validate $(EXTENSION)
	mkdir -p build/release
	cp $(EXTENSION) build/release/
	awk '/^## /{on = $$2 == "$(RELEASE)"; next} on' CHANGELOG.md > build/release/notes.md
	$(RUN) -m demo_scenes.title --out build/release/featured --width 1920 --height 1080
	$(RUN) -m demo_scenes.gallery build/release ibiza_sunset --size 256 --format PNG
	mv build/release/ibiza_sunset.png build/release/icon.png

# the documentation as a site: open build/site/index.html
docs: $(ENV)/ready $(DOCS)/ready
	$(RUN) -m tools.docs build/site --python $(DOCS)/bin/python

# the part of it that the extension holds
MANUAL := docs/html/manual.html
$(MANUAL): $(ENV)/ready $(DOCS)/ready blender_manifest.toml addon/core/manual.py docs/start.md docs/manual.md docs/formats.md \
		$(shell find docs/manual tools/docs -type f -not -name '*.pyc')
	$(RUN) -m tools.docs docs/html --manual --python $(DOCS)/bin/python

# the fits of the starter library, and their asset library, in the extension too; LIBRARY=few makes those of 24 materials
LIBRARY := all
$(STARTER): $(ENV)/ready build/library-$(LIBRARY) \
		$(shell find addon/core addon/starter fitter osl -type f -not -name '*.pyc')
	rm -rf $(@D)
	$(RUN) -m tools.ready_fits $(@D)/fits $(LIBRARY)
	$(RUN) . starter -o $(@D) --only-ready

build/library-$(LIBRARY):
	mkdir -p build
	rm -f build/library-*
	touch $@

zip: $(EXTENSION)

$(EXTENSION): $(ENV)/ready $(MANUAL) $(STARTER) blender_manifest.toml __init__.py __main__.py $(shell find addon fitter osl -type f -not -name '*.pyc')
	$(RUN) tools/blender_extension.py build --source-dir . --output-filepath $@
	$(RUN) tools/blender_extension.py validate $@

$(ENV)/ready: pyproject.toml
	@test -n "$(VERSION)" || { echo "Python 3.11 or 3.13 is needed; name it with PYTHON=..."; exit 1; }
	$(PYTHON) -m venv --clear $(ENV)
	$(RUN) -m pip install --quiet pip==26.3
	$(RUN) -m pip install --quiet --group test
	@$(RUN) -c 'import bpy' || { echo "bpy does not start. On Debian it needs: apt-get install $(DEBIAN)"; exit 1; }
	touch $@

$(LINT)/ready: pyproject.toml
	@test -n "$(VERSION)" || { echo "Python 3.11 or 3.13 is needed; name it with PYTHON=..."; exit 1; }
	$(PYTHON) -m venv --clear $(LINT)
	$(LINT)/bin/python -m pip install --quiet pip==26.3
	$(LINT)/bin/python -m pip install --quiet --group lint
	touch $@

$(DOCS)/ready: pyproject.toml
	@test -n "$(VERSION)" || { echo "Python 3.11 or 3.13 is needed; name it with PYTHON=..."; exit 1; }
	$(PYTHON) -m venv --clear $(DOCS)
	$(DOCS)/bin/python -m pip install --quiet pip==26.3
	$(DOCS)/bin/python -m pip install --quiet --group docs
	touch $@

clean:
	rm -rf build docs/html starter_library
