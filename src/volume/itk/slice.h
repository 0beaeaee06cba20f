/* SPDX-License-Identifier: MIT */
/* slice.h - one picture, by that of ITK's readers that takes it. */
#ifndef ISO_VOLUME_ITK_SLICE_H
#define ISO_VOLUME_ITK_SLICE_H

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
};

/* Its header; throws Failure, or ITK's own. */
Slice open_slice(const std::string &path);
/* All samples of the file; `bytes` is what the header says they take. */
void read_samples(const Slice &s, char *out, size_t bytes);

/* While it lives, the memory for what GDCM parses of files of at most so many bytes. Data of implicit VR under a header
 * that says explicit have lengths of gigabytes, which GDCM would allocate and clear, each time that a file is read,
 * before it reads the data as they are: this it does as soon as it gets no memory. */
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

/* The bytes of a file that GDCM parses; of a deflated one those that it may unpack to. */
double bytes_to_parse(const std::string &path);

/* What an exception says. */
std::string cause_of(const std::exception &e);

#endif
