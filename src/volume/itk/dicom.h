/* SPDX-License-Identifier: MIT */
/* dicom.h - the header of a DICOM file, by PS3.3, from the file's own elements.
 *
 * Spacing and places: PixelSpacing, else NominalScannedPixelSpacing, else ImagerPixelSpacing; ImagePositionPatient and
 * ImageOrientationPatient; GridFrameOffsetVector; SpacingBetweenSlices. Functional groups of the frame come before the
 * shared ones, and both before the file's own elements. A missing element has no default: its spacing counts
 * as missing in the file. Values: RescaleSlope and RescaleIntercept, DoseGridScaling. GDCM parses elements and
 * decodes compressed samples; its own geometry and scale are not used. */
#pragma once

#include "volume/itk/dicom_color.h"
#include "volume/itk/stack.h"

struct DicomFrame {
    Plane plane;
    bool has_place = false;
    Vector u{1, 0, 0}, v{0, 1, 0}; /* from pixel to pixel in a row, and from row to row */
    double slope = 1, intercept = 0;
    unsigned segment = 0; /* its number; 0: none, as in all files but segmentations */
};

struct DicomSegment {
    unsigned number;
    std::string name;
};

enum class Samples { integer, float32, float64 };

struct DicomFile {
    std::string path;
    std::string series, description, instance; /* UIDs, and the series' name */
    double number = 0;                         /* InstanceNumber */
    size_t columns = 0, rows = 0;
    size_t tiles = 0; /* of a mosaic, in a row; 0: none. A frame is a tile */
    Coding coding;
    Palette palette;
    size_t channels = 1, channel = 0; /* of colors; the one that is given, `channels` for their luminance */
    /* Samples as they are given, one per pixel: */
    Samples samples = Samples::integer;
    unsigned bits_allocated = 0, bits_stored = 0, high_bit = 0;
    bool is_signed = false;
    std::string value_unit; /* "", or the unit of the rescaled values: HU */
    double padding = 0; /* PixelPaddingValue, as stored; 0: none, or black */
    bool has_direction = false;
    std::vector<DicomFrame> frames;
    std::vector<DicomSegment> segments; /* of a segmentation */
    bool is_label_map = false;          /* True for a segmentation whose samples are numbers of segments */
    std::string unspaced; /* "", or the spacing that is missing in the file */
    std::string warning;  /* "", or a warning for the user */
};

/* True if the file starts as DICOM files do. */
bool has_mark_of_dicom(const std::string &path);
/* Reads the header of a file that holds an image; false if it is none. Throws Failure if it is damaged, or if its
 * samples are of a kind that is not read. */
bool read_dicom(const std::string &path, DicomFile &file);

/* True if the deflated file was read to its end. GDCM reports some of these as damaged. */
bool is_whole_deflated(const std::string &path);
/* Chooses what is given of colors. */
void choose_channel(DicomFile &file, size_t channel);
/* All samples of a file, as they are coded, in the machine's byte order. */
struct Coded {
    Coding coding; /* of decoded samples, which may differ from the file's */
    std::vector<char> bytes;
};
Coded coded_samples(const DicomFile &file);
/* Returns the samples of a frame, one per pixel: in `coded` if they stand there, else in `own`. */
const char *frame_samples(const DicomFile &file, const Coded &coded, size_t frame, std::vector<char> &own);
/* Returns the type that holds the values of all frames: an integer if slopes and intercepts are. */
iso_type type_of_values(const std::vector<DicomFile> &files);
/* Converts a stored frame to values of that type. */
void values_of_frame(const DicomFile &file, size_t frame, const char *stored, iso_type type, char *out);
/* Replaces the first slice by (1 - weight) of it and weight of the second; integers are rounded. */
void blend(iso_type type, double weight, const char *second, size_t count, char *first);
