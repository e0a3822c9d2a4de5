# The service as an image: one binary, a software Vulkan driver for the preview, no root, no shell needed.
#
#   docker build -t meshcolor .
#   docker run --rm --read-only --tmpfs /tmp --cap-drop ALL --security-opt no-new-privileges \
#     -v meshcolor-data:/data -p 127.0.0.1:8080:8080 meshcolor

FROM rust:1.95-bookworm AS builder
WORKDIR /build
COPY Cargo.toml Cargo.lock ./
COPY core/ core/
COPY shaders/ shaders/
COPY service/ service/
COPY tests/ tests/
RUN cargo build --release --locked -p meshcolor && strip target/release/meshcolor

FROM debian:bookworm-slim
# A static image could not load a Vulkan driver; without one the CPU renderer draws the preview.
RUN apt-get update \
    && apt-get install -y --no-install-recommends mesa-vulkan-drivers \
    && rm -rf /var/lib/apt/lists/* \
    && install -d -o 65532 -g 65532 /data
COPY --from=builder /build/target/release/meshcolor /meshcolor
COPY LICENSE-MIT LICENSE-APACHE LICENSE-FONT /licenses/

# Nothing but /data and /tmp is written. The driver keeps its shader cache off the read-only root, and
# looks for no desktop session.
ENV MESHCOLOR_BIND=0.0.0.0:8080 \
    MESHCOLOR_DATA=/data \
    MESA_SHADER_CACHE_DISABLE=true \
    NODEVICE_SELECT=1 \
    XDG_RUNTIME_DIR=/tmp
USER 65532:65532
VOLUME /data
EXPOSE 8080
HEALTHCHECK --interval=10s --timeout=6s --start-period=5s CMD ["/meshcolor", "health"]
STOPSIGNAL SIGTERM
ENTRYPOINT ["/meshcolor"]
CMD ["serve"]
