# SPDX-License-Identifier: MIT
"""Formats of other fields: FreeSurfer, AFNI, MRtrix, FITS, OpenDX, VASP, VTK's parallel and HDF5 files. Cases of formats_in.py.

Where no program of Debian writes a format, the file is written here by its description and another program reads it.
"""
import gzip
import itertools
import os

import numpy as np

from formats_matrix import SAY, check, values_of
from formats_matrix import SPACING as PLAIN
from phantom import (FIRST, LPS, SPACING, STEPS, case, cut, expect, must_choose, phantom, refused, run, same,
                     vtk_image, vtk_write)


def affine():
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = STEPS, FIRST
    return matrix


@case
def mgh():
    import nibabel
    for dtype, ending in zip((np.uint8, np.int16, np.int32, np.float32), ("mgh", "mgz", "mgh", "mgz")):
        values = phantom(dtype)
        nibabel.MGHImage(values.T, affine()).to_filename(f"p.{ending}")
        same(f"p.{ending}", values if dtype != np.int32 else values.astype(np.float32), tolerance=1e-4)
    both = np.stack([phantom(np.float32), phantom(np.float32) * 2])
    image = nibabel.MGHImage(both.T, affine())
    image.header["tr"] = 1500
    image.to_filename("t.mgz")
    must_choose("t.mgz", "has 2 frames (1500 ms apart)")
    same("t.mgz", both[1], options=["--frame", "1"], tolerance=1e-4)
    nibabel.MGHImage(phantom(np.int16).T, affine()).to_filename("p.mgh")
    cut("p.mgh", "cut.mgh")
    refused("cut.mgh", 4, "truncated")
    with open("p.mgh", "r+b") as file:  # without a place: coronal, 1 mm, around the origin
        file.seek(28)
        file.write(b"\0\0")
    steps = np.array([[-1, 0, 0], [0, 0, 1], [0, -1, 0]], float)
    same("p.mgh", phantom(np.int16), steps, -steps @ (np.array(phantom().shape[::-1]) / 2), tolerance=1e-4)


@case
def fits():
    from astropy.io import fits as astro
    for dtype in "u1", "i2", "i4", "i8", "u8", "f4", "f8":
        values = values_of(dtype)
        astro.PrimaryHDU(values).writeto("p.fits", overwrite=True)
        check("p.fits", values, None, SAY, dtype)
    refused("p.fits", 4, "does not state the spacing of its voxels in a unit of length (its axes have: none, none, none)")
    image = astro.PrimaryHDU(values_of("u2"))  # which FITS stores as int16 and an offset
    for axis, unit in enumerate(("mm", "um", "mm"), 1):
        image.header[f"CUNIT{axis}"] = unit
        image.header[f"CDELT{axis}"] = PLAIN[axis - 1] * (1000 if unit == "um" else 1)
        image.header[f"CRPIX{axis}"], image.header[f"CRVAL{axis}"] = 2, 5
    image.writeto("p.fits", overwrite=True)
    check("p.fits", values_of("u2").astype(np.float32), None, (), "scaled")
    lines = {line.split()[0]: line for line in run("info", "p.fits").stdout.splitlines() if line.startswith("  ")}
    expect(lines["corner"].split()[1:3] == [f"{5 - 1.5 * PLAIN[0]:g},", f"{5e-3 - 1.5 * PLAIN[1]:g},"], lines["corner"])
    turn = np.array([[0, -2e-3, 0], [3e-3, 0, 0], [0, 0, 5e-3]])  # mm
    for matrix in "CD", "PC":
        image = astro.PrimaryHDU(values_of("i2"))
        for i in range(1, 4):
            image.header[f"CUNIT{i}"] = "um"
            if matrix == "PC":
                image.header[f"CDELT{i}"] = 2.0
        for i, j in zip(*np.nonzero(turn)):
            image.header[f"{matrix}{i + 1}_{j + 1}"] = turn[i, j] * 1e3 / (2 if matrix == "PC" else 1)
        if matrix == "PC":
            image.header["PC1_1"] = image.header["PC2_2"] = 0.0
        image.writeto("turn.fits", overwrite=True)
        check("turn.fits", values_of("i2"), turn, (), matrix)
    radio = astro.PrimaryHDU(values_of("f4")[:, None])  # a Stokes axis of one sample before the last
    for axis, unit in enumerate(("deg", "deg", "", "Hz"), 1):
        radio.header[f"CUNIT{axis}"] = unit
    radio.writeto("r.fits", overwrite=True)
    refused("r.fits", 4, "(its axes have: deg, deg, Hz)")
    check("r.fits", values_of("f4"), None, SAY, "radio")
    times = np.stack([values_of("i2"), values_of("i2") + 1])
    parts = [astro.PrimaryHDU(), astro.ImageHDU(times, name="TIMES"), astro.ImageHDU(values_of("f4"), name="SCI"),
             astro.ImageHDU(np.zeros((3, 3), "f4"), name="FLAT")]
    astro.HDUList(parts).writeto("m.fits", overwrite=True)
    refused("m.fits", 2, "holds several images of three axes, FILE:PART must be one of: 1 TIMES, 2 SCI", SAY)
    refused("m.fits:3", 2, "has no such image of three axes, FILE:PART must be one of: 1 TIMES, 2 SCI", SAY)
    check("m.fits:sci", values_of("f4"), None, SAY, "part")
    check("m.fits:1", times[1], None, [*SAY, "--frame", "1"], "frame")
    astro.HDUList([astro.PrimaryHDU(), astro.CompImageHDU(values_of("i2"))]).writeto("c.fits", overwrite=True)
    refused("c.fits", 4, "fpack packed", SAY)
    cut("p.fits", "cut.fits", 0.5)
    refused("cut.fits", 4, "cut.fits: ", SAY)


@case
def opendx():
    values = values_of("f4")
    x, y, z = values.shape[::-1]
    with open("p.dx", "w", encoding="ascii") as file:
        file.write(f"# of APBS\nobject 1 class gridpositions counts {x} {y} {z}\norigin 1 2 3\n"
                   f"delta {PLAIN[0]} 0 0\ndelta 0 {PLAIN[1]} 0\ndelta 0 0 {PLAIN[2]}\n"
                   f"object 2 class gridconnections counts {x} {y} {z}\n"
                   f"object 3 class array type double rank 0 items {x * y * z} data follows\n")
        flat = values.T.ravel()  # z fastest
        for at in range(0, flat.size, 3):
            file.write(" ".join(f"{v:.6e}" for v in flat[at:at + 3]) + "\n")
        file.write('attribute "dep" string "positions"\nobject "regular" class field\n')
    check("p.dx", values, np.diag(PLAIN) * 1e-7, (), "text")
    same("p.dx", values, np.diag(PLAIN) * 1e-7, np.array([1, 2, 3]) * 1e-7, False, unit="angstrom", tolerance=1e-12)
    with gzip.open("p.dx.gz", "wb") as file, open("p.dx", "rb") as plain:
        file.write(plain.read())
    check("p.dx.gz", values, np.diag(PLAIN) * 1e-7, (), "gzip")
    with open("p.dx", encoding="ascii") as file:
        text = file.read()
    for old, new, why in (("data follows", "binary data follows", 'must be "data follows"'),
                          ("items 60", "items 61", "61 samples for a grid of"), ("delta 0 0", "beta 0 0", "with 1 lines"),
                          (text[-400:], "", "truncated")):
        with open("bad.dx", "w", encoding="ascii") as file:
            file.write(text.replace(old, new))
        refused("bad.dx", 4, why)


@case
def vasp():
    values = np.abs(values_of("f4"))
    cell = np.array([[4.0, 0, 0], [1, 5, 0], [0, 0.5, 6]])
    x, y, z = values.shape[::-1]
    volume = np.linalg.det(2 * cell)

    def write(name, numbers, old=False, more=""):
        with open(name, "w", encoding="ascii") as file:
            file.write("made up\n 2.0\n" + "".join(" %f %f %f\n" % tuple(row) for row in cell))
            file.write(("" if old else " Si O\n") + " 1 2\nDirect\n" + " 0.0 0.1 0.2\n" * 3 + f"\n {x} {y} {z}\n")
            flat = numbers.ravel()
            for at in range(0, flat.size, 5):
                file.write(" ".join(f"{v:.11E}" for v in flat[at:at + 5]) + "\n")
            file.write(more)
    steps = (2 * cell / np.array([[x], [y], [z]])).T * 1e-7
    write("CHGCAR", values * volume, more="augmentation occupancies   1  2\n  0.1 0.2\n" + f" {x} {y} {z}\n" + " 1.0" * 60)
    same("CHGCAR", values, steps, np.zeros(3), False, unit="angstrom", tolerance=1e-12)
    write("LOCPOT", values, old=True, more=f" {x} {y} {z}\n" + " 1.0" * 60)
    same("LOCPOT", values, steps, np.zeros(3), False, unit="angstrom", tolerance=1e-12)
    cut("LOCPOT", "LOCPOT_cut", 0.3)
    refused("LOCPOT_cut", 4, "LOCPOT_cut: ")


def write_mif(path, values, layout, datatype, matrix=None, separate=False):
    """values [x, y, z] or [x, y, z, t]. The layout has the sign and the rank of each axis."""
    ranks = [abs(int(word)) for word in layout.split(",")]
    stored = values[tuple(slice(None, None, -1) if word[0] == "-" else slice(None) for word in layout.split(","))]
    data = np.transpose(stored, [ranks.index(r) for r in range(len(ranks))[::-1]])
    data = np.ascontiguousarray(data).astype({"LE": "<", "BE": ">"}.get(datatype[-2:], "=") + values.dtype.str[1:]).tobytes()
    matrix = affine() if matrix is None else matrix
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    rows = [",".join(f"{c:.15g}" for c in (*(matrix[r, :3] / lengths), matrix[r, 3])) for r in range(3)]
    vox = [f"{c:.15g}" for c in lengths] + ["2.5"] * (values.ndim - 3)
    head = (f"mrtrix image\ndim: {','.join(map(str, values.shape))}\nvox: {','.join(vox)}\nlayout: {layout}\n"
            f"datatype: {datatype}\n" + "".join(f"transform: {row}\n" for row in rows))
    with open(path, "wb") as file:
        if separate:
            file.write((head + "file: beside.dat 7\n").encode())  # MRtrix writes no END here
            with open(os.path.join(os.path.dirname(path), "beside.dat"), "wb") as beside:
                beside.write(b"\0" * 7 + data)
        else:
            file.write((head + "file: . 512\nEND\n").encode().ljust(512, b"\0") + data)


@case
def mrtrix():
    layouts = ["+0,+1,+2", "-0,-1,+2", "+2,-0,+1", "-1,+2,-0"]
    types = {"u1": "UInt8", "i2": "Int16LE", "u2": "UInt16BE", "f4": "Float32LE", "f8": "Float64BE"}
    for layout, (dtype, name) in zip(itertools.cycle(layouts), types.items()):
        values = phantom(np.dtype(dtype))
        write_mif("p.mif", values.T, layout, name)
        # the grid is the file's: turned back, it is the phantom at its place
        ranks = [abs(int(word)) for word in layout.split(",")]
        signs = [-1 if word[0] == "-" else 1 for word in layout.split(",")]
        stored = values.T[tuple(slice(None, None, s) for s in signs)]
        order = [ranks.index(r) for r in range(3)]
        steps = (STEPS * signs)[:, order]
        first = FIRST + sum(STEPS[:, a] * (values.T.shape[a] - 1) for a in range(3) if signs[a] < 0)
        wanted = np.transpose(stored, order[::-1])
        same("p.mif", wanted.astype(np.float32) if dtype == "f8" else wanted, steps, first, tolerance=1e-4)
    both = np.stack([phantom(), phantom() + 1], -1)
    for layout in "+0,+1,+2,+3", "+1,+2,+3,+0":
        write_mif("t.mif", np.stack([phantom().T, phantom().T + 1], -1), layout, "Int16LE")
        must_choose("t.mif", "has 2 frames (2.5 s apart)")
        same("t.mif", both[..., 1], options=["--frame", "1"], tolerance=1e-4)
    write_mif("./h.mih", phantom().T, "+0,+1,+2", "Int16LE", separate=True)
    same("h.mih", phantom(), tolerance=1e-4)
    cut("p.mif", "cut.mif")
    refused("cut.mif", 4, "truncated")
    write_mif("c.mif", phantom().T, "+0,+1,+2", "CFloat32LE")
    refused("c.mif", 4, 'its type is "CFloat32LE", must be an integer or float')


def write_afni(path, values, factors, byteorder="LSB"):
    """values [t, z, y, x]. nibabel has to read the same."""
    codes = {"u1": 0, "i2": 1, "f4": 3}
    lps = LPS @ np.column_stack([STEPS, FIRST])

    def attribute(kind, name, numbers):
        if kind == "string":
            return f"\ntype  = string-attribute\nname  = {name}\ncount = {len(numbers) + 1}\n'{numbers}~\n"
        lines = "".join(f" {v:.10g}" for v in numbers)
        return f"\ntype  = {kind}-attribute\nname  = {name}\ncount = {len(numbers)}\n{lines}\n"
    t, z, y, x = values.shape
    with open(path + ".HEAD", "w", encoding="ascii") as file:
        file.write(attribute("integer", "DATASET_RANK", [3, t, 0, 0, 0, 0, 0, 0]) +
                   attribute("integer", "DATASET_DIMENSIONS", [x, y, z, 0, 0]) +
                   attribute("string", "TYPESTRING", "3DIM_HEAD_ANAT") + attribute("integer", "SCENE_DATA", [0, 2, 0] + [-999] * 5) +
                   attribute("integer", "ORIENT_SPECIFIC", [0, 3, 4]) + attribute("float", "ORIGIN", lps[:, 3]) +
                   attribute("float", "DELTA", SPACING) + attribute("float", "IJK_TO_DICOM_REAL", lps.ravel()) +
                   attribute("string", "BYTEORDER_STRING", byteorder + "_FIRST") +
                   attribute("integer", "BRICK_TYPES", [codes[values.dtype.str[1:]]] * t) +
                   attribute("float", "BRICK_FLOAT_FACS", factors) + attribute("integer", "TAXIS_NUMS", [t, 0, 77002]) +
                   attribute("float", "TAXIS_FLOATS", [0, 2.5, 0, 0, 0]))
    data = values.astype((">" if byteorder == "MSB" else "<") + values.dtype.str[1:]).tobytes()
    with open(path + ".BRIK", "wb") as file:
        file.write(data)


@case
def afni():
    import nibabel
    for dtype, byteorder in ("u1", "LSB"), ("i2", "MSB"), ("i2", "LSB"), ("f4", "LSB"):
        values = np.stack([phantom(np.dtype(dtype))])
        write_afni("p+orig", values, [0], byteorder)
        same("p+orig.HEAD", values[0], tolerance=1e-4)
        peer = nibabel.load("p+orig.HEAD")
        expect(np.allclose(peer.affine[:3, :3], STEPS, atol=1e-5) and np.allclose(peer.affine[:3, 3], FIRST, atol=1e-4),
               f"nibabel: {peer.affine}")
        expect(np.array_equal(np.squeeze(peer.get_fdata()).T, values[0]), "nibabel reads other values")
    both = np.stack([phantom(), phantom() + 1])
    write_afni("t+orig", both, [0.5, 0.25])
    must_choose("t+orig.HEAD", "has 2 frames (2.5 s apart)")
    same("t+orig.HEAD", (both[1] * 0.25).astype(np.float32), options=["--frame", "1"], tolerance=1e-4)
    with gzip.open("t+orig.BRIK.gz", "wb") as file, open("t+orig.BRIK", "rb") as plain:
        file.write(plain.read())
    os.remove("t+orig.BRIK")
    same("t+orig.HEAD", (both[1] * 0.25).astype(np.float32), options=["--frame", "1"], tolerance=1e-4)
    cut("p+orig.BRIK", "short")
    os.replace("short", "p+orig.BRIK")
    refused("p+orig.HEAD", 4, "truncated")
    # without the matrix: by DICOM's axes
    with open("t+orig.HEAD", encoding="ascii") as file:
        text = file.read()
    with open("t+orig.HEAD", "w", encoding="ascii") as file:
        file.write(text.replace("IJK_TO_DICOM_REAL", "NOTHING"))
    same("t+orig.HEAD", (both[1] * 0.25).astype(np.float32), np.diag(SPACING) * [[-1], [-1], [1]], FIRST,
         options=["--frame", "1"], tolerance=1e-4)


# ---- VTK ----

@case
def vti_packers():
    import vtk
    for packer, mode, dtype in itertools.product(("LZ4", "LZMA", "ZLib"), (1, 2), (np.uint8, np.float32)):
        writer = vtk.vtkXMLImageDataWriter()
        getattr(writer, f"SetCompressorTypeTo{packer}")()
        writer.SetDataMode(mode)
        writer.SetBlockSize(512)
        vtk_write(writer, vtk_image(phantom(dtype), STEPS, FIRST), "packed.vti")
        same("packed.vti", phantom(dtype), ras=False)
        cut("packed.vti", "cut.vti", 0.7)
        refused("cut.vti", 4, "truncated")


@case
def parallel_image():
    import vtk
    for dtype in np.int16, np.float32:
        writer = vtk.vtkXMLPImageDataWriter()
        writer.SetNumberOfPieces(3)
        writer.SetStartPiece(0)
        writer.SetEndPiece(2)
        source = vtk.vtkTrivialProducer()  # which gives pieces of its data
        source.SetOutput(vtk_image(phantom(dtype), STEPS, FIRST))
        extent = [n for size in phantom().shape[::-1] for n in (0, size - 1)]
        source.SetWholeExtent(*extent)
        writer.SetInputConnection(source.GetOutputPort())
        writer.SetFileName("p.pvti")
        writer.Write()
        same("p.pvti", phantom(dtype), ras=False)
    # Pieces along z that share a plane, of extents that do not start at 0; one by one by VTK.
    values = phantom(np.int16)
    pieces = ""
    for k, (a, b) in enumerate(((0, 2), (2, 5), (5, 6))):
        image = vtk_image(values[a:b + 1].copy(), np.diag(SPACING), [1, 2, 3])
        image.SetExtent(-2, 8, 3, 15, a + 4, b + 4)
        vtk_write(vtk.vtkXMLImageDataWriter(), image, f"own_{k}.vti")
        pieces += f'<Piece Extent="-2 8 3 15 {a + 4} {b + 4}" Source="own_{k}.vti"/>'

    def write(body):
        with open("own.pvti", "w", encoding="ascii") as file:
            file.write('<VTKFile type="PImageData" version="0.1"><PImageData WholeExtent="-2 8 3 15 4 10" GhostLevel="0" '
                       f'Origin="1 2 3" Spacing="0.75 0.5 2.5">{body}</PImageData></VTKFile>')
    write(pieces)
    same("own.pvti", values, np.diag(SPACING), [1, 2, 3] + SPACING * [-2, 3, 4], False)
    write(pieces[:pieces.rindex("<Piece")])
    refused("own.pvti", 4, "its 2 pieces do not fill the whole")
    write(pieces.replace("own_1", "../own_1"))
    refused("own.pvti", 4, "must be a .vti in its folder or below")
    write(pieces.replace("own_1.vti", "own_0.vti"))
    refused("own.pvti", 4, "along axis 3, must be 4")
    write("")
    refused("own.pvti", 4, "without pieces")


@case
def parallel_rectilinear():
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk
    values, steps = phantom(np.int16), np.array(SPACING)

    def write(name, coordinates, pieces=3):
        grid = vtk.vtkRectilinearGrid()
        grid.SetDimensions(*values.shape[::-1])
        for axis, c in zip("XYZ", coordinates):
            getattr(grid, f"Set{axis}Coordinates")(numpy_to_vtk(c.astype(float), deep=1))
        grid.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=1))
        writer = vtk.vtkXMLPRectilinearGridWriter()
        writer.SetNumberOfPieces(pieces)
        writer.SetStartPiece(0)
        writer.SetEndPiece(pieces - 1)
        source = vtk.vtkTrivialProducer()
        source.SetOutput(grid)
        source.SetWholeExtent(*[n for size in values.shape[::-1] for n in (0, size - 1)])
        writer.SetInputConnection(source.GetOutputPort())
        writer.SetFileName(name)
        writer.Write()
    even = [1 + a + np.arange(n) * steps[a] for a, n in enumerate(values.shape[::-1])]
    write("p.pvtr", even)
    same("p.pvtr", values, np.diag(steps), [1, 2, 3], False)
    last = even[2].copy()
    last[-1] += 3 * steps[2]
    write("uneven.pvtr", [*even[:2], last], 1)
    refused("uneven.pvtr", 4, "must be equal within 1 %")
    # pieces that are even, but not together
    with open("p.pvtr", encoding="ascii") as file:
        text = file.read()
    first = text.index("<Piece")
    write("p.pvtr", [c + 0.1 * steps[a] for a, c in enumerate(even)])
    os.rename("p_2.vtr", "moved.vtr")
    write("p.pvtr", even)
    with open("p.pvtr", "w", encoding="ascii") as file:
        file.write(text[:first] + text[first:].replace("p_2.vtr", "moved.vtr"))
    refused("p.pvtr", 4, "uneven: moved.vtr begins")
    grid = vtk.vtkStructuredGrid()
    vtk_write(vtk.vtkXMLStructuredGridWriter(), grid, "s.vts")
    refused("s.vts", 4, "is a grid of VTK that is not read, unlike .vti, .vtr, .pvti and .pvtr")


@case
def vtkhdf():
    import h5py
    for dtype in np.int16, np.float32:
        with h5py.File("p.vtkhdf", "w") as file:
            group = file.create_group("VTKHDF")
            group.attrs["Version"] = [1, 0]
            group.attrs["Type"] = np.bytes_("ImageData")
            group.attrs["WholeExtent"] = [1, 11, 0, 12, 2, 8]
            group.attrs["Origin"] = FIRST - STEPS @ [1, 0, 2]
            group.attrs["Spacing"] = SPACING
            group.attrs["Direction"] = (STEPS / SPACING).ravel()
            group["PointData/s"] = phantom(dtype)
        same("p.vtkhdf", phantom(dtype), ras=False)


@case
def npz():
    values = values_of("i2")
    np.savez("p.npz", values)
    np.savez_compressed("q.npz", image=values.astype(">f4"), other=values_of("u1"), flat=np.eye(3))
    check("p.npz", values, None, SAY, "plain")
    check("q.npz:image", values.astype("f4"), None, SAY, "packed")
    check("q.npz:other.npy", values_of("u1"), None, SAY, "packed")
    refused("q.npz", 2, "holds several arrays, FILE:NAME must be one of: image, other, flat", SAY)
    refused("q.npz:none", 2, "has no such array", SAY)
    refused("q.npz:flat", 4, "q.npz: its shape is (3, 3), a volume has 3 axes", SAY)
    cut("q.npz", "cut.npz", 0.5)
    refused("cut.npz", 4, "cut.npz: ", SAY)
