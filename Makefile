# seamtrack. `make demo` and `make test` need nothing but Rust (1.88 or later) on a Debian machine: they install the
# system packages by themselves and ask nothing.

CARGO ?= cargo
SEEDS ?= 1-5
ABLATION_SEEDS ?= 61-63
KINDS_SEEDS ?= 121-124
SENSORS_SEED ?= 1
REGRESS ?=
PLATES_SEEDS ?= 201-205
FAULTS_SEED ?= 1
FUZZ_INPUTS ?= 1000000
FUZZ_SEED ?= 1
CALIBRATED_SEEDS ?= 301-312

.PHONY: demo pictures test wheel python python-test fleet-test build setup checks bench speed regress ablation kinds sensors calibrated plates faults fuzz soak kills deny peers live-demo live-test clean

# Exit code 3 says that a verdict is BAD: that of the other method may be.
demo: build
	./target/release/seamtrack track fixtures/demo-butt --truth fixtures/demo-butt/truth.csv --mm-per-px 0.073 \
	  --overlay results/demo-butt/overlay -o results/demo-butt --force
	./target/release/seamtrack track fixtures/demo-butt --truth fixtures/demo-butt/truth.csv \
	  --preset paper -o results/demo-butt-paper --force --quiet || [ $$? -eq 3 ]
	./target/release/seamtrack compare results/demo-butt results/demo-butt-paper -o results/demo-comparison.html --force
	./target/release/seamtrack synth H-butt-covers --seed 61 --frames 120 -o results/demo-covers-recording --force
	./target/release/seamtrack track results/demo-covers-recording --truth results/demo-covers-recording/truth.csv \
	  --mm-per-px 0.073 -o results/demo-covers --force
	./target/release/seamtrack track results/demo-covers-recording --truth results/demo-covers-recording/truth.csv \
	  --preset paper -o results/demo-covers-paper --force --quiet || [ $$? -eq 3 ]
	./target/release/seamtrack compare results/demo-covers results/demo-covers-paper \
	  -o results/demo-covers-comparison.html --force
	./target/release/seamtrack track fixtures/demo-hairline --truth fixtures/demo-hairline/truth.csv --mm-per-px 0.217 \
	  --max-unavailable 100 --overlay results/demo-hairline/overlay -o results/demo-hairline --force
	@echo
	@echo "Look at results/demo-butt/report.html (the run) and results/demo-butt/overlay (the frames with their marks); at the"
	@echo "methods beside one another, where they hardly differ: results/demo-comparison.html, and where the seam is covered"
	@echo "now and then: results/demo-covers-comparison.html; and at the difficult recording, a fitted joint under an arc:"
	@echo "results/demo-hairline/report.html and results/demo-hairline/overlay."

# The screenshot of the README, by the browser that the tests use; the pictures of the notebook.
pictures: setup
	./scripts/install-packages chromium
	$(CARGO) test --test report_in_browser -- --ignored the_picture_of_the_readme
	$(MAKE) python
	target/python/bin/python python/examples/run_notebook.py docs/pictures

build: setup
	$(CARGO) build --release

# The whole test command: format, lints, documentation, tests.
test: setup
	./scripts/install-packages chromium
	$(MAKE) checks
	$(CARGO) test --no-fail-fast
	@if ./scripts/python-environment; then $(MAKE) python-test; \
	  else echo "SKIPPED: the packages for Python could not be installed (no network?), so the Python package was not tested" >&2; fi

# The Python package: one wheel for CPython 3.10 and later, without OpenCV. target/python is its environment.
wheel:
	@./scripts/python-environment
	rm -rf target/wheels
	target/python/bin/maturin build --release -o target/wheels

python: wheel
	target/python/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall target/wheels/*.whl

# Format and lints of the native part, then its tests from Python; the program is what it is held against.
python-test: python setup
	$(CARGO) fmt -p seamtrack-python --check
	$(CARGO) clippy -p seamtrack-python -- -D warnings
	$(CARGO) build
	target/python/bin/python -m pytest -q python/tests

# Fleets on Ray with a node killed, on a Slurm array where Slurm is, and from an S3 server: minutes; installs Ray and moto.
fleet-test: python
	@./scripts/python-environment fleet
	target/python/bin/python -m pytest -q -s python/fleet_tests

checks: setup
	$(CARGO) fmt --check
	$(CARGO) clippy --all-targets -- -D warnings
	$(CARGO) clippy --example ablation --features ablation -- -D warnings
	$(CARGO) clippy --lib --no-default-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --no-deps

# OpenCV and what builds its bindings.
setup:
	@./scripts/install-packages libopencv-dev clang libclang-dev

# Measured, never asserted.
bench: setup
	$(CARGO) bench --bench step --bench kalman --bench meltpool

# A step of the tracker beside OpenCV's KCF and MOSSE on the same frames, in turn, on one thread; and by phase and size.
speed: setup
	$(CARGO) run --release --features peers --example speed

# All built-in scenes over several seeds, one table.
regress: setup
	$(CARGO) run --release --example regress -- --seeds $(SEEDS) $(REGRESS)

# What each part of the robust method is worth: it is taken away, and the table printed.
ablation: setup
	$(CARGO) run --release --features ablation --example ablation -- --seeds $(ABLATION_SEEDS)

# Which joint is found by itself, and when, in every kind of scene.
kinds: setup
	$(CARGO) run --release --example kinds -- --seeds $(KINDS_SEEDS)

# 300 recordings of random sensors, joints, paths and lights: about ten minutes on two cores. Each seed draws others.
sensors: setup
	$(CARGO) run --release --example sensors -- --seed $(SENSORS_SEED)

# From board images to a seam in millimetres: errors told apart into the picture's and the calibration's, each with its own σ.
calibrated: build
	$(CARGO) run --release --example calibrated -- --seeds $(CALIBRATED_SEEDS)

# Plates with marks, beads, curves, reflections; and plates without a seam: families × levels × seeds, the joint not told.
plates: setup
	$(CARGO) run --release --example plates -- --seeds $(PLATES_SEEDS)

# What becomes of recordings to which something happens, at random places; then pictures without a seam.
faults: setup
	$(CARGO) run --release --example faults -- --seed $(FAULTS_SEED)

# Hostile inputs to everything that reads; what breaks a promise is kept in fuzz/artifacts. With cargo-fuzz and a nightly
# compiler the same targets run guided: `cargo +nightly fuzz run session`.
fuzz: setup
	$(CARGO) run --release --example fuzz -- --inputs $(FUZZ_INPUTS) --seed $(FUZZ_SEED)

# 200,000 frames through one session: memory, time a frame, covariances.
soak: setup
	$(CARGO) run --release --example soak

# 500 runs killed at random moments, 50 pairs at once, full and read-only disks: what is there afterwards.
kills: build
	$(CARGO) run --release --example kills

# Licences, bans and sources of what is built in, by deny.toml: without a network. Then advisories, which need a copy of their
# list: where it cannot be fetched that fails.
deny:
	@$(CARGO) deny --version >/dev/null 2>&1 || \
	  { echo "cargo-deny is missing, so nothing was checked: cargo install --locked cargo-deny" >&2; exit 1; }
	$(CARGO) deny --all-features check licenses bans sources
	$(CARGO) deny --all-features check advisories

# The trackers a user would otherwise take, on the same frames in the same run (rebuilds the OpenCV bindings).
peers: setup
	$(CARGO) run --release --features peers --example peers -- --seeds $(SEEDS)

# A closed loop without a robot: `seamtrack live` at a simulated cell for 20 s, then where the torch was.
live-demo: build
	./scripts/live-demo

# Long closed loops, cameras and the page, and programs of others where SEAMTRACK_PEERS names a Python with pymodbus, RSIPI and
# ABBRobotEGM. Some minutes; the machine must have nothing else to do. The features' code is built and tested here only.
live-test: setup
	@./scripts/install-packages libaravis-dev libusb-1.0-0-dev aravis-tools chromium
	$(CARGO) clippy --all-targets --features camera,page -- -D warnings
	$(CARGO) test --release --features camera,page --lib live::
	$(CARGO) test --release --features camera,page --test live -- --include-ignored --nocapture --test-threads 1

clean:
	$(CARGO) clean
	rm -rf results
