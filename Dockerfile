# docker build -t goalwire . && docker run --rm -it --network host goalwire ros2 topic list
# Not built yet by us: there was no Docker where this was written.
FROM python:3.13-slim AS build
WORKDIR /source
COPY . .
RUN pip install --no-cache-dir build && python -m build --wheel --outdir /dist

FROM python:3.13-slim
COPY --from=build /dist /dist
RUN pip install --no-cache-dir "$(ls /dist/*.whl)[bag,bridge]" && rm -r /dist && useradd --create-home robot
USER robot
WORKDIR /home/robot
CMD ["ros2", "--help"]
