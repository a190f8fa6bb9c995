ARG BASE=python:3.11-slim
FROM ${BASE} AS build
WORKDIR /src
COPY pyproject.toml requirements.lock README.md LICENSE ./
COPY service service
COPY drivers drivers
COPY db db
RUN python3 -m venv /opt/drumtrue \
 && /opt/drumtrue/bin/pip install --no-cache-dir --disable-pip-version-check -c requirements.lock . \
 && find /opt/drumtrue/lib/python3*/site-packages/scipy -type d -name tests -prune -exec rm -rf {} + \
 && /opt/drumtrue/bin/pip uninstall --yes --quiet setuptools pip

ARG BASE=python:3.11-slim
FROM ${BASE}
COPY --from=build /opt/drumtrue /opt/drumtrue
RUN useradd --uid 1000 --create-home drumtrue && mkdir /data && chown drumtrue /data
USER 1000
ENV PATH=/opt/drumtrue/bin:$PATH PYTHONDONTWRITEBYTECODE=1 DRUMTRUE_DATABASE_URL=sqlite:////data/drumtrue.db
VOLUME /data
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=5s --retries=3 \
  CMD ["python3", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/health', timeout=4)"]
ENTRYPOINT ["drumtrue"]
CMD ["serve", "--host", "0.0.0.0", "--port", "8000"]
