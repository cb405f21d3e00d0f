# cbdsl with all engines: docker build -t cbdsl . && docker run --rm -v "$PWD:/work" cbdsl validate .
FROM debian:bookworm-slim AS system
RUN apt-get update \
    && apt-get install --yes --no-install-recommends git python3-venv libegl1 libgl1 libgl1-mesa-dri libgomp1 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home cb

FROM system
COPY . /src
RUN python3 -m venv /opt/cbdsl \
    && /opt/cbdsl/bin/pip install --no-cache-dir --disable-pip-version-check --constraint /src/constraints.txt "/src[sim]" \
        /src/distributions/cbdsl-calibration /src/distributions/cbdsl-compare /src/distributions/cbdsl-mujoco /src/distributions/cbdsl-report /src/distributions/cbdsl-why \
    && rm -rf /src
USER cb
ENV PATH=/opt/cbdsl/bin:$PATH
# Machine code of the compiled functions, so that the first run starts immediately.
RUN cb warm
WORKDIR /work
ENTRYPOINT ["cb"]
