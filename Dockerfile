# Everything built and ready to run, on nothing but Debian's own packages:
#     docker build -t matchbox_slam .
#     docker run --rm -it --network host -v "$PWD:/data" matchbox_slam map_bag /data/my.bag --out /data/result
FROM debian:12
# Of what comes later scripts/build.sh installs all that is missing.
RUN apt-get update \
    && apt-get install -y --no-install-recommends ca-certificates git \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /matchbox_slam
COPY . .
RUN scripts/build.sh
ENV PATH=/matchbox_slam/.workspace/devel/lib/matchbox_slam:$PATH
ENTRYPOINT ["/bin/bash", "-c", "source /matchbox_slam/.workspace/devel/setup.bash && exec \"$@\"", "--"]
CMD ["bash"]
