# The planner with everything it needs; scenes and results are folders of the host:
#   docker build -t stplan --build-arg VERSION=$(python -m setuptools_scm) .
#   docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" stplan batch scenes -o outputs
FROM python:3.12-slim
# The history that a version is made of is not copied; without an argument it is that of the last release.
ARG VERSION=""
COPY pyproject.toml README.md LICENSE /source/
COPY stplan /source/stplan
RUN SETUPTOOLS_SCM_PRETEND_VERSION="$VERSION" pip install --no-cache-dir "/source[dask]" && rm -rf /source
# The kernels' machine code, made once; whoever runs the container, on another processor, adds to it.
ENV NUMBA_CACHE_DIR=/var/cache/stplan
RUN stplan doctor --compile && chmod -R a+rwX /var/cache/stplan
WORKDIR /work
ENTRYPOINT ["stplan"]
CMD ["--help"]
