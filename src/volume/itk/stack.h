/* SPDX-License-Identifier: MIT */
/* stack.h - DICOM's slices as a grid: in the order in which they stand, and apart by time where several stand at each
 * place. The slices are files of a series, or the frames of one file. */
#pragma once

#include <string>
#include <vector>

#include "volume/itk/slice.h"

/* A key that may distinguish slices of one place; the first that does is taken. */
struct PlaneKey {
    const char *tag; /* as ITK's dictionary has it */
    const char
        *unit; /* of its numbers; "" if they only count, "clock" for HHMMSS, or YYYYMMDDHHMMSS before a zone */
};
extern const std::vector<PlaneKey> plane_keys;

struct Plane {
    std::string name; /* for messages */
    Vector first{0, 0, 0};
    std::vector<std::string> keys;    /* of each of plane_keys, "" if it has none */
    double resolution_ms = 0;         /* TemporalResolution; 0: absent */
    double repetition_ms = 0;         /* RepetitionTime; 0: absent */
    double number = 0;                /* InstanceNumber; NAN: absent */
    size_t times = 0;                 /* NumberOfTemporalPositions; 0: absent */
    double digit = 0, turn_digit = 0; /* units of the last digits of its place, and of its direction */
};

/* A slice between two planes: (1 - weight) of the first, and weight of the second. */
struct Between {
    size_t first, second;
    double weight;
};

struct Stack {
    std::vector<size_t> planes; /* of the frame that is wanted, in their order */
    std::vector<Between> slices; /* of planes that are not equally far apart; indices into `planes` */
    size_t made = 0;             /* how many of them are between two planes */
    Vector step{0, 0, 1};       /* from one to the next */
    size_t frames = 1;
    double frame_step = 0; /* 0: not given, or uneven */
    std::string frame_unit;
};

/* Makes a stack along the normal of the planes, which have to be equally far apart, or are treated by wanted.uneven.
 * Throws Failure if one is missing, or if several at one place differ in no key. Under a tilted gantry the step is
 * oblique to the planes. */
Stack stack_of(const std::vector<Plane> &planes, const Vector &u, const Vector &v, const Wanted &wanted,
               const std::string &shown);
