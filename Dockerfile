# cablewright in a container, without root:
#   docker build --tag cablewright .
#   docker run --rm --volume "$PWD:/work" cablewright check house-printer house.toml
# EXTRAS are those of pyproject.toml: docker build --build-arg EXTRAS=web,fem --tag cablewright .
FROM python:3.13-slim AS build
WORKDIR /source
COPY requirements/build.in requirements/run.txt requirements/
COPY pyproject.toml README.md LICENSE ./
COPY src src
RUN python -m pip install --no-cache-dir --requirement requirements/build.in build \
    && python -m build --wheel --no-isolation --outdir /wheels

FROM python:3.13-slim
ARG EXTRAS=web
COPY --from=build /source/requirements/run.txt /tmp/run.txt
COPY --from=build /wheels /wheels
RUN python -m pip install --no-cache-dir --require-hashes --requirement /tmp/run.txt \
    && python -m pip install --no-cache-dir "$(echo /wheels/*.whl)[$EXTRAS]" \
    && rm -r /wheels /tmp/run.txt \
    && useradd --create-home --uid 1000 operator
USER operator
ENV CABLEWRIGHT_CACHE_DIR=/home/operator/.cache/cablewright
WORKDIR /work
ENTRYPOINT ["cablewright"]
CMD ["--help"]
