/* SPDX-License-Identifier: MIT */
#include "volume/itk/slice.h"

#include <itkJPEGImageIO.h>
#include <itkPNGImageIO.h>
#include <itkTIFFImageIO.h>

#include <cstring>
#include <filesystem>
#include <fstream>

namespace {

itk::ImageIOBase::Pointer reader_of(const std::string &path)
{
    const itk::ImageIOBase::Pointer all[] = {
        itk::PNGImageIO::New().GetPointer(),
        itk::JPEGImageIO::New().GetPointer(),
        itk::TIFFImageIO::New().GetPointer(),
    };
    for (const auto &io : all)
        if (io->CanReadFile(path.c_str()))
            return io;
    return nullptr;
}

iso_type type_of(const itk::ImageIOBase &io, const std::string &path)
{
    using Type = itk::IOComponentEnum;
    if (io.GetNumberOfComponents() < 1 || io.GetNumberOfComponents() > 4)
        fail(ISO_E_FORMAT, path + ": " + std::to_string(io.GetNumberOfComponents()) +
                               " components per voxel, not supported in this format");
    switch (io.GetComponentType()) {
    case Type::UCHAR: return ISO_U8;
    case Type::CHAR: return ISO_I8;
    case Type::USHORT: return ISO_U16;
    case Type::SHORT: return ISO_I16;
    case Type::UINT: return ISO_U32;
    case Type::INT: return ISO_I32;
    case Type::FLOAT: return ISO_F32;
    case Type::DOUBLE: return ISO_F64;
    default:
        fail(ISO_E_FORMAT, path + ": type \"" + io.GetComponentTypeAsString(io.GetComponentType()) +
                               "\", must be an integer of 8, 16 or 32 bits, float or double");
    }
}

} // namespace

/* Adds to the memory in use: libraries hold parsed data up to four times. No thread begins in that time, since its
 * stack would take memory for each core. */
ParseMemory::ParseMemory(double file_bytes)
{
    double used = 0;
    std::ifstream file("/proc/self/statm");
    for (int i = 0; i < 6; ++i) /* the sixth is the memory that RLIMIT_DATA counts, in pages */
        file >> used;
    getrlimit(RLIMIT_DATA, &before_);
    const double most = used * static_cast<double>(sysconf(_SC_PAGESIZE)) + own_memory + 4 * file_bytes;
    rlimit less = before_;
    if (file && most < static_cast<double>(before_.rlim_cur))
        less.rlim_cur = static_cast<rlim_t>(most);
    setrlimit(RLIMIT_DATA, &less);
}

ParseMemory::~ParseMemory()
{
    setrlimit(RLIMIT_DATA, &before_);
}

double bytes_to_parse(const std::string &path)
{
    std::string head(1024, 0);
    std::ifstream(path, std::ios::binary).read(&head[0], static_cast<std::streamsize>(head.size()));
    std::error_code failed;
    const double bytes = static_cast<double>(std::filesystem::file_size(path, failed));
    return failed ? 0 : bytes * (head.find(deflated_syntax) == std::string::npos ? 1 : 1032);
}

/* Returns the cause. ITK's text has lines with the place of the throw, and its own words before the cause. */
std::string cause_of(const std::exception &e)
{
    const auto *itk = dynamic_cast<const itk::ExceptionObject *>(&e);
    if (!itk)
        return e.what();
    const std::string text = itk->GetDescription();
    const size_t at = text.find("): ");
    return "ITK: " + (text.compare(0, 4, "ITK ") == 0 && at != std::string::npos ? text.substr(at + 3) : text);
}

Slice open_slice(const std::string &path)
{
    const ParseMemory memory(bytes_to_parse(path));
    Slice s;
    s.path = path;
    s.io = reader_of(path);
    if (!s.io)
        fail(ISO_E_FORMAT, path + ": not a file that ITK reads");
    s.io->SetFileName(path);
    try {
        s.io->ReadImageInformation();
    } catch (const itk::ExceptionObject &e) {
        fail(ISO_E_FORMAT, path + ": " + cause_of(e));
    }
    const unsigned axes = s.io->GetNumberOfDimensions();
    for (unsigned a = 3; a < axes; ++a)
        if (s.io->GetDimensions(a) != 1)
            fail(ISO_E_FORMAT, path + ": " + std::to_string(axes) + " axes, not supported in this format");
    s.type = type_of(*s.io, path);
    s.stored = s.io->GetNumberOfComponents();
    for (unsigned a = 0; a < 3 && a < axes; ++a)
        s.size[a] = s.io->GetDimensions(a);
    return s;
}

namespace {

/* Refuses a truncated file, for which the decoder draws gray; a whole one has its end marker, followed at most by
 * padding. */
void check_jpeg_end(const Slice &s)
{
    const size_t size = std::filesystem::file_size(s.path), look = std::min<size_t>(size, 4096);
    std::string end(look, 0);
    std::ifstream file(s.path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(size - look));
    file.read(&end[0], static_cast<std::streamsize>(look));
    if (dynamic_cast<const itk::JPEGImageIO *>(s.io.GetPointer()) && end.find("\xff\xd9") == std::string::npos)
        fail(ISO_E_FORMAT, s.path + ": truncated: a JPEG file without its end marker");
}

} // namespace

void read_samples(const Slice &s, char *out, size_t bytes)
{
    itk::ImageIORegion region(s.io->GetNumberOfDimensions());
    for (unsigned a = 0; a < s.io->GetNumberOfDimensions(); ++a) {
        region.SetIndex(a, 0);
        region.SetSize(a, s.io->GetDimensions(a));
    }
    s.io->SetIORegion(region);
    if (static_cast<size_t>(s.io->GetImageSizeInBytes()) != bytes)
        fail(ISO_E_FORMAT, s.path + ": holds " + std::to_string(s.io->GetImageSizeInBytes()) +
                               " bytes of samples, not " + std::to_string(bytes));
    check_jpeg_end(s);
    /* Decoders hold their output several times. */
    const ParseMemory memory(bytes_to_parse(s.path) + 4 * static_cast<double>(bytes));
    try {
        s.io->Read(out);
    } catch (const itk::ExceptionObject &e) { /* of a folder, the file is to be named */
        fail(ISO_E_FORMAT, s.path + ": " + cause_of(e));
    }
}
