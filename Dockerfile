FROM python:3.12-slim AS build
WORKDIR /src
COPY . .
# The image has no history of git to find the version in: docker build --build-arg VERSION=0.6.0 .
ARG VERSION=
# The versions that were tested, by the sums of their files; what builds the wheel too.
RUN pip install --no-cache-dir --upgrade "pip>=25.3" \
  && ${VERSION:+env SETUPTOOLS_SCM_PRETEND_VERSION=$VERSION} pip wheel --no-cache-dir --no-deps \
    --build-constraint requirements-dev.lock --wheel-dir /wheels . \
  && pip wheel --no-cache-dir --require-hashes --requirement requirements.lock --wheel-dir /wheels

FROM python:3.12-slim
RUN useradd --create-home --uid 10001 mcml
COPY --from=build /wheels /wheels
RUN pip install --no-cache-dir --no-index --find-links /wheels "mcml-repository[server,cluster,plots,openid]" && rm -rf /wheels
USER mcml
# Made by their owner, or Docker would make the volumes' folders as root.
RUN mkdir /home/mcml/data /home/mcml/cache /home/mcml/backups
ENV MCML_HOST=0.0.0.0 MCML_PORT=8000 XDG_DATA_HOME=/home/mcml/data
VOLUME /home/mcml/data
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=3s --start-period=20s \
  CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8000/healthz', timeout=2)"]
CMD ["mcml", "serve"]
