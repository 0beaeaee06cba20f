#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Central differences of a volume of 16 bits: isoshade beside VTK's and ITK's gradient filters, in one run.

    tests/peers/gradients.py [--size 512] [--runs 5] [--isoshade ./isoshade]

Each program takes the least time of its runs, with one thread and with all cores; the rounds alternate between the programs, so
that what else the machine does meets all of them. In memory, buffers touched before. Debian packages: python3-vtk9,
libinsighttoolkit5-dev (and g++). VTK has no output but double, so it writes twice the bytes.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ITK = "/usr/include/ITK-5.2"


def isoshade(args, threads, runs):
    command = [args.isoshade, "bench", "build", "--size", str(args.size), "--runs", str(runs), "--threads", str(threads),
               "--levels", "1", "--json"]
    found = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["gradients_to_float"]
    return found["seconds"], found["memcpy_seconds_same_bytes"]


def vtk_seconds(size, runs, threads, smp):
    """In a process of its own: VTK's number of threads is set once."""
    import vtk
    from vtkmodules.util import numpy_support
    import numpy
    vtk.vtkSMPTools.Initialize(threads)
    image = vtk.vtkImageData()
    image.SetDimensions(size, size, size)
    voxels = ((numpy.arange(size ** 3, dtype=numpy.uint32) * numpy.uint32(2654435761)) >> 8).astype(numpy.uint16)
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(voxels))
    gradient = vtk.vtkImageGradient()
    gradient.SetInputData(image)
    gradient.SetDimensionality(3)
    gradient.SetEnableSMP(smp)
    gradient.SetNumberOfThreads(threads)
    best = float("inf")
    for _ in range(runs):
        gradient.Modified()
        start = time.perf_counter()
        gradient.Update()
        best = min(best, time.perf_counter() - start)
    at = (size + 1) * size + 1
    wanted = 0.5 * (float(voxels[at + 1]) - float(voxels[at - 1]))
    found = gradient.GetOutput().GetScalarComponentAsDouble(1, 1, 1, 0)
    if not abs(found - wanted) <= 1e-3 * 65535:
        sys.exit(f"VTK: {found} at (1, 1, 1), wanted {wanted}")
    print(best)


def vtk(args, threads, runs):
    """The faster of VTK's two ways to use threads."""
    best = float("inf")
    for smp in "01":
        command = ["/usr/bin/python3", __file__, "--vtk", smp, "--size", str(args.size), "--runs", str(runs), "--threads", str(threads)]
        best = min(best, float(subprocess.run(command, check=True, capture_output=True).stdout))
    return best


def build_itk(folder):
    program = os.path.join(folder, "itk_gradient")
    subprocess.run(["g++", "-std=c++17", "-O3", "-DNDEBUG", "-march=native", "-w", f"-I{ITK}", os.path.join(HERE, "itk_gradient.cc"), "-o",
                    program, "-lITKCommon-5.2", "-litkvnl-5.2", "-litkvnl_algo-5.2", "-litksys-5.2", "-lpthread"], check=True)
    return program


def check_packages():
    code = subprocess.run(["/usr/bin/python3", "-c", "import vtk"], capture_output=True).returncode
    if code != 0:
        sys.exit("VTK for Python is missing: apt-get install python3-vtk9")
    if not os.path.isdir(ITK):
        sys.exit("ITK is missing: apt-get install libinsighttoolkit5-dev")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--isoshade", default=os.path.join(HERE, "..", "..", "isoshade"))
    parser.add_argument("--vtk", choices="01", help=argparse.SUPPRESS)
    parser.add_argument("--threads", type=int, default=0, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.vtk:
        vtk_seconds(args.size, args.runs, args.threads, args.vtk == "1")
        return
    check_packages()
    cores = len(os.sched_getaffinity(0))
    rounds = 2
    runs = max(1, args.runs // rounds)
    print(f"{args.size}^3 of uint16, least of {rounds * runs} runs; load average {os.getloadavg()[0]:.1f} on {cores} cores")
    print(f"{'threads':>7} {'isoshade':>10} {'memcpy':>10} {'VTK':>10} {'ITK':>10}   VTK / isoshade   ITK / isoshade")
    with tempfile.TemporaryDirectory() as folder:
        itk = build_itk(folder)
        for threads in sorted({1, cores}):
            ours = copy = theirs = itks = float("inf")
            for _ in range(rounds):
                seconds, memcpy = isoshade(args, threads, runs)
                ours, copy = min(ours, seconds), min(copy, memcpy)
                theirs = min(theirs, vtk(args, threads, runs))
                command = [itk, str(args.size), str(runs), str(threads)]
                itks = min(itks, float(subprocess.run(command, check=True, capture_output=True).stdout))
            print(f"{threads:7} {ours:8.3f} s {copy:8.3f} s {theirs:8.3f} s {itks:8.3f} s {theirs / ours:16.1f} {itks / ours:16.1f}")


main()
