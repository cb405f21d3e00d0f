# Everything that has to hold before a change lands. CI calls `make check`; so can you.
PYTHON ?= .venv/bin/python
BIN = $(dir $(PYTHON))
# The tests to run, by pytest's marks: all. CI has already run the fast ones and asks for `slow`.
MARK ?= slow or not slow

# What a bill of materials is made for.
USERS = sim,editor,calibration,compare,drive,formats,learn,report,mujoco,gym,trees,mcap,mcp,lerobot,onnx,ros2,why

# First-party plug-ins.
DISTRIBUTIONS = $(wildcard distributions/cbdsl-*)

# How many mutants, which ones, and with which tests: `all` fast ones take minutes for each that is hard to kill. With a
# file in KEEP it can be interrupted, and goes on.
SAMPLE ?= 100
SEED ?= 0
REACH ?= all
KEEP ?=

# Learned documents to learn again: the stale ones.
NAMES ?=

# The version of the documentation, and another name of it.
VERSION ?= dev
ALIAS ?=

# How long each entry point is fuzzed, s, and which: all.
SECONDS ?= 60
TARGET ?=

.PHONY: check static format lint types layers spelling documents pages tests properties mutants relearn fuzz results first-day rclpy robosuite site site-version constraints dist sbom fix

check: static pages tests

# Each of these runs on one core; CI runs two of them at a time.
static: format lint types layers spelling documents

format:
	$(BIN)ruff format --check .

lint:
	$(BIN)ruff check .

types:
	$(BIN)mypy

layers:
	$(BIN)lint-imports
	for project in reproduction $(DISTRIBUTIONS); do $(BIN)lint-imports --config $$project/pyproject.toml || exit 1; done

spelling:
	$(BIN)codespell

documents:
	$(BIN)cb validate robots programs knowledge
	$(BIN)cb fmt --check robots programs knowledge

# Every page is in the navigation, and every link and heading that is linked to is there.
pages:
	NO_MKDOCS_2_WARNING=1 $(BIN)mkdocs build --strict --site-dir build/site

# The slow ones run episodes on the simulator.
tests:
	$(BIN)pytest -n auto --durations=40 --durations-min=20 -m "$(MARK)"

# Every single fault that can be put into a shipped document, which the tests sample: a quarter of an
# hour.
properties:
	$(BIN)pytest -n auto --hypothesis-profile=exhaustive tests/yaml_text/repair

# Small faults in control, sensing, runtime and learning that the fast tests have to notice.
mutants:
	$(BIN)python -m tests.mutants --sample $(SAMPLE) --seed $(SEED) --reach $(REACH) $(if $(KEEP),--keep $(KEEP))

# Stale knowledge, or the documents that NAMES lists, learned again by the commands in their provenance: hours.
relearn:
	$(BIN)python -m tests.relearn $(NAMES)

# Everything that reads text, fed with what reaches new branches: 26 entry points of SECONDS each.
fuzz:
	$(BIN)pip install --quiet --disable-pip-version-check -e ".[fuzz]"
	$(BIN)python -m tests.fuzz --seconds $(SECONDS) $(TARGET)

# The rows of docs/results.md that are missing or stale: hours. It can be interrupted, and goes on.
results:
	$(PYTHON) docs/make_results.py --measure

# A reader's first day, three times: a clone is set up, and what pages show is typed in a shell.
first-day:
	$(BIN)pytest -n 0 -m first_day tests/test_first_day.py

# A ROS 2 of another vendor's DDS, for tests and judges: rclpy with Fast DDS has wheels for Python 3.12 only.
RCLPY_PYTHON ?= python3.12

rclpy:
	$(RCLPY_PYTHON) -m venv build/rclpy
	build/rclpy/bin/pip install --quiet --disable-pip-version-check "ros-jazzy-rclpy[fastrtps]" \
	ros-jazzy-sensor-msgs ros-jazzy-trajectory-msgs ros-jazzy-test-msgs

# Robosuite, whose tasks `cb judge robosuite` judges by, apart because it needs an older MuJoCo and NumPy: 1.3 GB. Its
# numba and NumPy have wheels for Python 3.10 to 3.12.
ROBOSUITE_PYTHON ?= $(PYTHON)

robosuite:
	$(ROBOSUITE_PYTHON) -m venv build/robosuite
	build/robosuite/bin/pip install --quiet --disable-pip-version-check -r reproduction/robosuite.txt

# The documentation with replays of shipped programs and the playground, in site/; needs npm.
site:
	$(PYTHON) docs/make_gallery.py
	$(PYTHON) docs/make_playground.py
	NO_MKDOCS_2_WARNING=1 $(BIN)mkdocs build --strict --site-dir site

# The same as a version on the local branch gh-pages.
site-version:
	$(PYTHON) docs/make_gallery.py
	$(PYTHON) docs/make_playground.py
	PATH="$(abspath $(BIN)):$$PATH" CBDSL_DOCS_VERSIONS=mike NO_MKDOCS_2_WARNING=1 $(BIN)mike deploy --update-aliases $(VERSION) $(ALIAS)
	$(BIN)mike set-default --allow-undefined latest

# The versions that CI installs, for every supported Python; needs uv.
constraints:
	(echo "# Versions that CI installs, for Python 3.11 to 3.14: pip install -c constraints.txt ..."; \
	echo "# make constraints renews them."; \
	uv pip compile --quiet --universal --python-version 3.11 --no-header --no-annotate --upgrade \
	$(foreach name,cbdsl cbdsl-reproduction $(notdir $(DISTRIBUTIONS)),--no-emit-package $(name)) \
	--extra dev --extra release --extra fuzz pyproject.toml reproduction/pyproject.toml \
	$(DISTRIBUTIONS:%=%/pyproject.toml)) > build/constraints.txt
	mv build/constraints.txt constraints.txt
	(echo "# Tools that build the published files, with the digests that are allowed; make constraints renews it."; \
	printf 'build>=1.2\nhatchling>=1.25\n' | uv pip compile --quiet --universal --python-version 3.11 --no-header \
	--no-annotate --generate-hashes -) > build/requirements.txt
	mv build/requirements.txt .ci/build-requirements.txt

# Wheels and sdists of all distributions in dist/, checked where nothing else is installed.
dist:
	rm -rf dist
	$(BIN)pip install --quiet --disable-pip-version-check -e ".[release]"
	$(PYTHON) -m venv dist/builder
	dist/builder/bin/pip install --quiet --disable-pip-version-check --require-hashes -r .ci/build-requirements.txt
	for project in . reproduction $(DISTRIBUTIONS); do \
	dist/builder/bin/python -m build --no-isolation --outdir dist $$project || exit 1; done
	rm -rf dist/builder
	$(BIN)twine check --strict dist/*
	$(BIN)pytest -n 0 -m slow tests/test_distribution.py

# Everything that comes with cbdsl[sim] and the other extras of users, as CycloneDX in dist/sbom.json.
sbom: dist
	$(PYTHON) -m venv dist/bare
	dist/bare/bin/pip install --quiet --disable-pip-version-check --find-links dist "$$(echo dist/cbdsl-*.whl)[$(USERS)]"
	$(BIN)cyclonedx-py environment --pyproject pyproject.toml --output-reproducible --of JSON -o dist/sbom.json dist/bare/bin/python
	rm -rf dist/bare

fix:
	$(BIN)ruff check --fix .
	$(BIN)ruff format .
