/* SPDX-License-Identifier: MIT */
/* slice.h - one picture, by that of ITK's readers that takes it. */
#pragma once

#include <itkImageIOBase.h>

#include <sys/resource.h>

#include <array>
#include <string>

#include "volume/child_writer.h"

using Vector = std::array<double, 3>;

/* A file's header. */
struct Slice {
    std::string path;
    itk::ImageIOBase::Pointer io;
    iso_type type = ISO_U8;
    std::array<size_t, 3> size{1, 1, 1};
    size_t stored = 1; /* components of a pixel in the file */
};

/* Reads the header; throws Failure, or an exception of ITK. */
Slice open_slice(const std::string &path);
/* Reads all samples of the file; `bytes` is their size by the header. */
void read_samples(const Slice &s, char *out, size_t bytes);

/* A memory limit while it lives, for the data that GDCM parses of files of at most `file_bytes` bytes. Data of
 * implicit VR under a header of explicit VR have lengths of gigabytes. GDCM would allocate and clear these each time
 * that it reads a file, before it reads the data as they are. Without memory it does the latter at once. */
class ParseMemory {
public:
    explicit ParseMemory(double file_bytes);
    ParseMemory(const ParseMemory &) = delete;
    ParseMemory &operator=(const ParseMemory &) = delete;
    ~ParseMemory();

private:
    rlimit before_{};
};

constexpr char deflated_syntax[] = "1.2.840.10008.1.2.1.99";

/* Returns the bytes of the file that GDCM parses; for a deflated file, the most that it may unpack to. */
double bytes_to_parse(const std::string &path);

/* Returns the text of an exception. */
std::string cause_of(const std::exception &e);
