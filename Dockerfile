# The planner with everything it needs; scenes and results are folders of the host:
#   docker build -t stplan .
#   docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" stplan batch scenes -o outputs
FROM python:3.12-slim
COPY pyproject.toml README.md LICENSE /source/
COPY stplan /source/stplan
RUN pip install --no-cache-dir "/source[dask]" && rm -rf /source
# The kernels' machine code, made once; whoever runs the container, on another processor, adds to it.
ENV NUMBA_CACHE_DIR=/var/cache/stplan
RUN stplan doctor --compile && chmod -R a+rwX /var/cache/stplan
WORKDIR /work
ENTRYPOINT ["stplan"]
CMD ["--help"]
