"""Prints what independent readers (tifffile, zarr) see in stacks: one line a file, for the tests to compare."""
import sys

import numpy as np

for path in sys.argv[1:]:
    if path.endswith(".zarr"):
        import zarr

        group = zarr.open(path, "r")
        scales = group.attrs["multiscales"][0]
        axes = "".join(axis["name"] for axis in scales["axes"])
        steps = [d["coordinateTransformations"][0]["scale"] for d in scales["datasets"]]
        places = [d["coordinateTransformations"][1]["translation"] for d in scales["datasets"]]
        stack = np.moveaxis(group["0"][:], 0, 1)
        levels = [list(group[d["path"]].shape) for d in scales["datasets"]]
        channels = [c["label"] for c in group.attrs["omero"]["channels"]]
        print(path, scales["version"], axes, levels, steps[0], places[0], channels, end=" ")
    else:
        import tifffile

        with tifffile.TiffFile(path) as tiff:
            stack = tiff.asarray()
            kind = "ome" if tiff.is_ome else "imagej" if tiff.is_imagej else "plain"
            print(path, kind, "big" if tiff.is_bigtiff else "classic", tiff.series[0].axes, end=" ")
            if tiff.is_ome:
                open(path + ".xml", "w", encoding="utf-8").write(tiff.ome_metadata)
            else:
                print({k: tiff.imagej_metadata[k] for k in ("unit", "spacing", "slices", "channels")}, end=" ")
    print(stack.dtype, list(stack.shape))
    np.save(path.rstrip("/") + ".npy", stack.astype(np.float64))
