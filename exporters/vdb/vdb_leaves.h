/* SPDX-License-Identifier: MIT */
/* vdb_leaves.h - leaves on their way into a file: values are read and compressed by several threads, and written in the
 * leaves' order, so that the file's bytes do not depend on the number of threads. Private to exporters/vdb. */
#ifndef ISO_VDB_LEAVES_H
#define ISO_VDB_LEAVES_H

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <new>
#include <ostream>
#include <string>
#include <vector>

#include <openvdb/io/Compression.h>
#include <openvdb/openvdb.h>
#include <zlib.h>

#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

inline long clamp(long v, long size)
{
    return v < 0 ? 0 : v < size ? v : size - 1;
}

/* Row (y, z) of eight voxels from x on, counted from the first one, with edge values where it leaves the volume. */
inline void read_row(const iso_vdb_source &s, long x, long y, long z, float *row)
{
    const long nx = static_cast<long>(s.size[0]);
    const long first = clamp(x, nx), last = clamp(x + 7, nx);
    float inside[24];
    s.read(s.user, static_cast<size_t>(first), static_cast<size_t>(clamp(y, static_cast<long>(s.size[1]))),
           static_cast<size_t>(clamp(z, static_cast<long>(s.size[2]))), static_cast<size_t>(last - first + 1), inside);
    for (long i = 0; i < 8; ++i)
        for (int c = 0; c < s.channels; ++c)
            row[i * s.channels + c] = inside[(clamp(x + i, nx) - first) * s.channels + c];
}

inline void take(const float *v, float &out)
{
    out = v[0];
}
inline void take(const float *v, openvdb::Vec3f &out)
{
    out = openvdb::Vec3f(v[0], v[1], v[2]);
}

/* Deflates pieces one by one with one state, in place of a new one for each. */
class deflater {
public:
    deflater() = default;
    deflater(const deflater &) = delete;
    deflater &operator=(const deflater &) = delete;
    ~deflater()
    {
        if (ready_)
            deflateEnd(&state_);
    }

    /* As OpenVDB's zipToStream(): the number of bytes, then these; negative where they are not compressed. */
    void write(std::ostream &out, const char *data, size_t size)
    {
        start(size);
        state_.next_in = reinterpret_cast<Bytef *>(const_cast<char *>(data));
        state_.avail_in = static_cast<uInt>(size);
        state_.next_out = room_.data();
        state_.avail_out = static_cast<uInt>(room_.size());
        const bool smaller = deflate(&state_, Z_FINISH) == Z_STREAM_END && state_.total_out < size;
        const int64_t count = smaller ? static_cast<int64_t>(state_.total_out) : -static_cast<int64_t>(size);
        out.write(reinterpret_cast<const char *>(&count), sizeof count);
        out.write(smaller ? reinterpret_cast<const char *>(room_.data()) : data, std::abs(count));
    }

private:
    /* A leaf is at most 6 kB: a window of 4 kB and tables of as many bytes are set up again in a fraction of the time of the
     * usual ones. Level 4 makes directions .7 % larger than level 6 does, in three quarters of the time. */
    void start(size_t size)
    {
        const int level = 4, window_bits = 12, memory_level = 5;
        const int code = ready_
                             ? deflateReset(&state_)
                             : deflateInit2(&state_, level, Z_DEFLATED, window_bits, memory_level, Z_DEFAULT_STRATEGY);
        if (code != Z_OK)
            throw std::bad_alloc();
        ready_ = true;
        room_.resize(std::max<size_t>(room_.size(), deflateBound(&state_, size)));
    }

    z_stream state_ = {};
    bool ready_ = false;
    std::vector<Bytef> room_;
};

/* What is written is added to `bytes`. */
struct byte_buffer : std::streambuf {
    std::string bytes;

protected:
    std::streamsize xsputn(const char *from, std::streamsize count) override
    {
        bytes.append(from, static_cast<size_t>(count));
        return count;
    }
    int_type overflow(int_type c) override
    {
        bytes.push_back(traits_type::to_char_type(c));
        return c;
    }
};

/* Writes leaves as LeafNode::writeBuffers() does, from the source's values. For one thread. */
template <typename Leaf> class leaf_writer {
    using value = typename Leaf::ValueType;
    using half_value = typename openvdb::io::RealToHalf<value>::HalfT;

public:
    leaf_writer(const iso_vdb_source &source, uint32_t compression, bool to_half)
        : source_(source), compression_(compression), to_half_(to_half), out_(&buffer_)
    {
    }

    std::string &bytes()
    {
        return buffer_.bytes;
    }

    /* All that is not active is background, so that a leaf is its mask, a byte that says so, and its active values. */
    void write(const Leaf &leaf)
    {
        const size_t count = read_active(leaf);
        leaf.getValueMask().save(out_);
        out_.put(static_cast<char>(openvdb::io::NO_MASK_OR_INACTIVE_VALS));
        if (to_half_) {
            std::transform(values_, values_ + count, halves_, openvdb::io::RealToHalf<value>::convert);
            write_values(halves_, count);
        } else {
            write_values(values_, count);
        }
    }

private:
    /* Voxels of a leaf follow each other along z, then y: a word of the mask is a plane across x. */
    size_t read_active(const Leaf &leaf)
    {
        const iso_vdb_source &s = source_;
        const auto &active = leaf.getValueMask();
        const openvdb::Coord at = leaf.origin();
        float rows[64][24];
        uint64_t any = 0;
        for (openvdb::Index x = 0; x < 8; ++x)
            any |= active.template getWord<uint64_t>(x);
        for (int i = 0; i < 64; ++i)
            if (any >> i & 1)
                read_row(s, at.x() - s.first[0], at.y() + i / 8 - s.first[1], at.z() + i % 8 - s.first[2], rows[i]);
        size_t count = 0;
        for (openvdb::Index x = 0; x < 8; ++x)
            for (uint64_t left = active.template getWord<uint64_t>(x); left; left &= left - 1)
                take(rows[openvdb::util::FindLowestOn(left)] + x * static_cast<unsigned>(s.channels), values_[count++]);
        return count;
    }

    template <typename T> void write_values(const T *values, size_t count)
    {
        const char *bytes = reinterpret_cast<const char *>(values);
        if (compression_ & openvdb::io::COMPRESS_BLOSC)
            openvdb::io::bloscToStream(out_, bytes, sizeof *values, count);
        else if (compression_ & openvdb::io::COMPRESS_ZIP)
            deflater_.write(out_, bytes, count * sizeof *values);
        else
            out_.write(bytes, static_cast<std::streamsize>(count * sizeof *values));
    }

    const iso_vdb_source &source_;
    uint32_t compression_;
    bool to_half_;
    byte_buffer buffer_;
    std::ostream out_;
    deflater deflater_;
    value values_[Leaf::SIZE];
    half_value halves_[Leaf::SIZE];
};

/* The first exception that a thread meets, to be thrown where the threads have met again: none may leave its thread. */
class thread_failure {
public:
    template <typename Work> void guard(const Work &work)
    {
        try {
            if (!happened())
                work();
        } catch (...) {
#pragma omp critical(iso_vdb_thread_failure)
            if (!first_)
                first_ = std::current_exception();
        }
    }
    void rethrow() const
    {
        if (first_)
            std::rethrow_exception(first_);
    }

private:
    bool happened() const
    {
        bool any;
#pragma omp critical(iso_vdb_thread_failure)
        any = first_ != nullptr;
        return any;
    }

    std::exception_ptr first_;
};

template <typename Leaf>
void write_leaves(std::ostream &out, const std::vector<const Leaf *> &leaves, const iso_vdb_source &source,
                  bool to_half)
{
    const size_t piece = 32; /* leaves that a thread takes at once */
    const uint32_t compression = openvdb::io::getDataCompression(out);
    thread_failure failure;
#pragma omp parallel num_threads(source.threads)
    {
        leaf_writer<Leaf> writer(source, compression, to_half);
#pragma omp for ordered schedule(dynamic)
        for (size_t first = 0; first < leaves.size(); first += piece) {
            failure.guard([&] {
                writer.bytes().clear();
                for (size_t i = first; i < std::min(first + piece, leaves.size()); ++i)
                    writer.write(*leaves[i]);
            });
#pragma omp ordered
            failure.guard(
                [&] { out.write(writer.bytes().data(), static_cast<std::streamsize>(writer.bytes().size())); });
        }
    }
    failure.rethrow();
}

} // namespace iso_vdb

#endif
