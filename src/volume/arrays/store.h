/* SPDX-License-Identifier: MIT */
/* store.h - files that hold several arrays with attributes: HDF5, netCDF, Zarr. */
#ifndef ISO_VOLUME_ARRAYS_STORE_H
#define ISO_VOLUME_ARRAYS_STORE_H

#include <string>
#include <vector>

#include "volume/child_writer.h"

/* An array. Its axes stand as in C: the last one runs fastest. */
struct Array {
    std::string name;
    std::vector<size_t> size;
    std::vector<std::string> axes; /* their names; "" where they have none */
    iso_type type = ISO_U8;        /* of its samples, as they are given */
    bool is_whole = false;         /* doubles, of integers of 64 bits */
    std::string refused;           /* why it cannot be read; "" where it can */
    std::vector<size_t> chunk;     /* samples that are packed together; empty: none are */
};

/* For how many bytes of samples one of a file may stand where zeros are packed by zstd or blosc, or were never
 * written. zstd has 2^15 at most, blosc somewhat more; where a thousandth of the chunks is there, each packed to a
 * 130th, it is so many. */
constexpr double MOST_OF_A_BYTE = 1 << 17;

class Store {
public:
    virtual ~Store() = default;
    /* All arrays; those that cannot be read say why. */
    virtual std::vector<Array> arrays() = 0;
    /* An attribute; empty where there is none. */
    virtual std::vector<double> numbers(const std::string &array, const std::string &attribute) = 0;
    virtual std::string text(const std::string &array, const std::string &attribute) = 0;
    /* The array of one axis that says where the samples along an axis stand; "" where there is none. */
    virtual std::string coordinate(const Array &array, size_t axis) = 0;
    /* All values of a small array. */
    virtual std::vector<double> values(const std::string &array) = 0;
    /* A box of samples, in the machine's byte order. */
    virtual void read(const Array &array, const std::vector<size_t> &start, const std::vector<size_t> &count,
                      void *out) = 0;
    /* Geometry by rules of the format's own, such as OME's, into all of the header but its size and type; false: by its
     * coordinates. `space`: which axes of the array are x, y and z. */
    virtual bool place(const Array &, const size_t (&/* space */)[3], iso_child_header &)
    {
        return false;
    }
    /* The same of the step between frames. */
    virtual bool frame_step(const Array &, size_t /* axis */, double & /* step */, std::string & /* unit */)
    {
        return false;
    }
    /* The packed bytes that an array has, counted up to `enough`. Chunks that were never written have none: they are of
     * the fill value. Formats without such chunks have enough. */
    virtual double stored_bytes(const Array &, double enough)
    {
        return enough;
    }
    /* Memory for one chunk as it is unpacked, where a byte of the file may stand for more of it than deflate packs
     * into one; 0: for no more. */
    virtual size_t chunk_memory(const Array &)
    {
        return 0;
    }
    /* Names of channels; empty where the format has none. */
    virtual std::vector<std::string> channel_names(const Array &)
    {
        return {};
    }
    /* The name of the array that is meant where none is named; "" where the format does not say. Of formats that have an
     * array for each frame and channel, that of these. */
    virtual std::string main_array(size_t /* frame */, size_t /* channel */)
    {
        return "";
    }
    /* Values that stand for none, of other places than attributes. */
    virtual std::vector<double> fills(const Array &)
    {
        return {};
    }
    /* How many of these arrays there are; 1 in formats that have axes for them. */
    virtual size_t array_frames()
    {
        return 1;
    }
    virtual size_t array_channels()
    {
        return 1;
    }
};

/* 0, 1, 2: x, y, z of the world, by an axis' name or its `axis` attribute ("X"); -1: neither says so. */
int world_axis_of(const std::string &name, const std::string &letter);

std::unique_ptr<Store> open_hdf5(const std::string &path);
std::unique_ptr<Store> open_netcdf(const std::string &path);
std::unique_ptr<Store> open_zarr(const std::string &folder);

#endif
