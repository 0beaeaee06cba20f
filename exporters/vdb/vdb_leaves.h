/* SPDX-License-Identifier: MIT */
/* vdb_leaves.h - writing of leaves. Several threads read and compress values; the leaves are written in their order, so
 * that the file's bytes do not depend on the number of threads. Private to exporters/vdb. */
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <libdeflate.h>
#include <openvdb/io/Compression.h>
#include <openvdb/openvdb.h>

#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

inline long clamp(long v, long size)
{
    return v < 0 ? 0 : v < size ? v : size - 1;
}

/* Reads eight voxels of row (y, z) from x on, counted from the first voxel; repeats edge values outside the volume. */
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

/* Reads the active values of a leaf in the file's order; returns their number. Voxels of a leaf are stored along z first,
 * then y: a word of the mask is a plane across x. */
template <typename Leaf>
size_t read_active(const iso_vdb_source &s, const Leaf &leaf, typename Leaf::ValueType values[Leaf::SIZE])
{
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
            take(rows[openvdb::util::FindLowestOn(left)] + x * static_cast<unsigned>(s.channels), values[count++]);
    return count;
}

/* Compresses pieces with one reusable zlib state. */
class deflater {
public:
    deflater() : state_(libdeflate_alloc_compressor(level))
    {
        if (!state_)
            throw std::bad_alloc();
    }

    /* Like OpenVDB's zipToStream(): writes the number of bytes, then the bytes; a negative number if they are not
     * compressed. */
    void write(std::ostream &out, const char *data, size_t size)
    {
        room_.resize(std::max(room_.size(), size));
        const size_t packed = size ? libdeflate_zlib_compress(state_.get(), data, size, room_.data(), size - 1) : 0;
        const int64_t count = packed ? static_cast<int64_t>(packed) : -static_cast<int64_t>(size);
        out.write(reinterpret_cast<const char *>(&count), sizeof count);
        out.write(packed ? room_.data() : data, std::abs(count));
    }

private:
    /* Levels 2 to 6 take at least 1.5 times as long and gain nothing on leaves of directions (6 kB at most). */
    static constexpr int level = 1;

    struct release {
        void operator()(libdeflate_compressor *state) const { libdeflate_free_compressor(state); }
    };
    std::unique_ptr<libdeflate_compressor, release> state_;
    std::vector<char> room_;
};

/* Appends written data to `bytes`. */
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

/* Writes leaves as LeafNode::writeBuffers() does, from the source's values. One per thread. */
template <typename Leaf> class leaf_writer {
    using value = typename Leaf::ValueType;
    using half_value = typename openvdb::io::RealToHalf<value>::HalfT;

public:
    leaf_writer(const iso_vdb_source &source, uint32_t compression, bool to_half)
        : source_(source), compression_(compression), to_half_(to_half), out_(&buffer_)
    {
    }

    /* Takes the bytes written since the last call. */
    std::string take_bytes()
    {
        std::string taken = std::move(buffer_.bytes);
        buffer_.bytes.clear();
        return taken;
    }

    /* All inactive voxels are background, so a leaf is its mask, a byte for this rule, and its active values. */
    void write(const Leaf &leaf, size_t)
    {
        const size_t count = read_active(source_, leaf, values_);
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

/* Collects pieces of a file from several threads and writes them in order. An early piece waits here, and its thread
 * goes on, unless too many wait. Waiting inside an OpenMP loop would spin: on a busy machine that took two thirds of an
 * export's processor time. The first exception is kept and thrown after the threads have joined, since none may leave
 * its thread. */
class ordered_output {
public:
    ordered_output(std::ostream &out, size_t most) : out_(out), most_(most) {}

    /* Makes and hands in piece `number`; `make` returns its bytes. */
    template <typename Make> void piece(size_t number, const Make &make)
    {
        try {
            if (!has_failed())
                put(number, make());
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!failure_)
                failure_ = std::current_exception();
            room_.notify_all();
        }
    }

    void rethrow() const
    {
        if (failure_)
            std::rethrow_exception(failure_);
    }

private:
    bool has_failed()
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        return failure_ != nullptr;
    }

    void put(size_t number, std::string bytes)
    {
        std::unique_lock<std::mutex> lock(mutex_);
        room_.wait(lock, [&] { return failure_ || number == next_ || early_.size() < most_; });
        early_.emplace(number, std::move(bytes));
        if (is_writing_)
            return; /* the writing thread writes this piece too, when it is its turn */
        is_writing_ = true;
        for (auto first = early_.begin(); !failure_ && first != early_.end() && first->first == next_;
             first = early_.begin()) {
            const std::string ready = std::move(first->second);
            early_.erase(first);
            lock.unlock();
            out_.write(ready.data(), static_cast<std::streamsize>(ready.size()));
            lock.lock();
            ++next_;
            room_.notify_all();
        }
        is_writing_ = false;
    }

    std::ostream &out_;
    size_t most_, next_ = 0;
    bool is_writing_ = false;
    std::map<size_t, std::string> early_;
    std::mutex mutex_;
    std::condition_variable room_;
    std::exception_ptr failure_;
};

/* Leaves in the order of the file. */
template <typename Leaf> struct leaf_run {
    const Leaf *const *at;
    size_t count;
};

/* Writes leaves; make_writer: makes a thread's writer, which takes a leaf and its number in the run. */
template <typename Leaf, typename Make>
void write_run(std::ostream &out, const leaf_run<Leaf> &leaves, const iso_vdb_source &source, const Make &make_writer)
{
    const size_t piece = 32; /* leaves per piece */
    const size_t pieces = (leaves.count + piece - 1) / piece;
    ordered_output ordered(out, 4 * static_cast<size_t>(source.threads));
#pragma omp parallel num_threads(source.threads)
    {
        auto writer = make_writer();
#pragma omp for schedule(dynamic)
        for (size_t number = 0; number < pieces; ++number)
            ordered.piece(number, [&] {
                const size_t first = number * piece;
                for (size_t i = first; i < std::min(first + piece, leaves.count); ++i)
                    writer.write(*leaves.at[i], i);
                return writer.take_bytes();
            });
    }
    ordered.rethrow();
}

/* Returns the node above a leaf. The file has all leaves of a node, then those of the next. */
template <typename Leaf> openvdb::Coord node_of(const Leaf &leaf)
{
    const int voxels = 128;
    return leaf.origin() & ~(voxels - 1);
}

/* Prepares the voxels that leaves are read from, if the source requires it; edge voxels for those outside. */
template <typename Leaf> void prepare_run(const leaf_run<Leaf> &leaves, const iso_vdb_source &s)
{
    if (!s.prepare)
        return;
    openvdb::Coord lo = leaves.at[0]->origin(), hi = lo;
    size_t first[3], end[3];
    for (size_t i = 1; i < leaves.count; ++i) {
        lo.minComponent(leaves.at[i]->origin());
        hi.maxComponent(leaves.at[i]->origin());
    }
    for (int a = 0; a < 3; ++a) {
        const long size = static_cast<long>(s.size[a]);
        first[a] = static_cast<size_t>(clamp(lo[a] - s.first[a], size));
        end[a] = static_cast<size_t>(clamp(hi[a] + 7 - s.first[a], size)) + 1;
    }
    if (!s.prepare(s.prepare_user, first, end))
        throw std::bad_alloc();
}

template <typename Leaf>
void write_leaves(std::ostream &out, const std::vector<const Leaf *> &leaves, const iso_vdb_source &source,
                  bool to_half)
{
    const uint32_t compression = openvdb::io::getDataCompression(out);
    for (size_t first = 0, end = 0; first < leaves.size(); first = end) {
        const openvdb::Coord node = node_of(*leaves[first]);
        while (end < leaves.size() && (!source.prepare || node_of(*leaves[end]) == node))
            ++end;
        const leaf_run<Leaf> run = {leaves.data() + first, end - first};
        prepare_run(run, source);
        write_run(out, run, source, [&] { return leaf_writer<Leaf>(source, compression, to_half); });
    }
}

} // namespace iso_vdb
