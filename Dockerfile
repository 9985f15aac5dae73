# The planner with everything it needs; scenes and results are folders of the host:
#   docker build -t stplan .
#   docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" stplan batch scenes -o outputs
FROM python:3.12-slim AS build
COPY pyproject.toml README.md LICENSE /source/
COPY stplan /source/stplan
RUN pip install --no-cache-dir --prefix=/usr/local "/source[dask]"

FROM python:3.12-slim
COPY --from=build /usr/local /usr/local
# Machine code of the kernels is made once, here, and read by whoever runs the container.
COPY scenes/bottleneck /tmp/scenes
RUN stplan solve /tmp/scenes/bottleneck.yaml -o /tmp/outputs --quiet && rm -rf /tmp/scenes /tmp/outputs
WORKDIR /work
ENTRYPOINT ["stplan"]
CMD ["--help"]
