/* SPDX-License-Identifier: MIT */
/* store.h - files that hold several arrays with attributes: HDF5, netCDF, Zarr. */
#pragma once

#include <string>
#include <vector>

#include "volume/child_writer.h"

/* An array. Its axes stand as in C: the last one runs fastest. */
struct Array {
    std::string name;
    std::vector<size_t> size;
    std::vector<std::string> axes; /* their names; "" if they have none */
    iso_type type = ISO_U8;        /* of its samples, as they are given */
    bool is_whole = false;         /* doubles, of integers of 64 bits */
    std::string refused;           /* reason why it cannot be read; "" if it can */
    std::vector<size_t> chunk;     /* samples that are packed together; empty: none are */
};

/* Largest number of sample bytes per byte of a file, for zeros packed by zstd or blosc, or never written. zstd has
 * 2^15 at most, blosc somewhat more. The limit allows a thousandth of the chunks, each packed to a 130th. */
constexpr double MOST_OF_A_BYTE = 1 << 17;

class Store {
public:
    virtual ~Store() = default;
    /* Returns all arrays; unreadable ones have the reason. */
    virtual std::vector<Array> arrays() = 0;
    /* Returns an attribute; empty if there is none. */
    virtual std::vector<double> numbers(const std::string &array, const std::string &attribute) = 0;
    virtual std::string text(const std::string &array, const std::string &attribute) = 0;
    /* Returns the array of one axis with the positions of the samples along an axis; "" if there is none. */
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
    /* Returns the memory for unpacking one chunk, if a byte of the file may unpack to more than by deflate; 0: not
     * more. */
    virtual size_t chunk_memory(const Array &)
    {
        return 0;
    }
    /* Returns names of channels; empty if the format has none. */
    virtual std::vector<std::string> channel_names(const Array &)
    {
        return {};
    }
    /* Returns the default array's name; "" if the format defines none. In formats that have an array for each frame
     * and channel, it is theirs. */
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

/* Returns 0, 1, 2 for x, y, z of the world, by an axis' name or its `axis` attribute ("X"); -1: by neither. */
int world_axis_of(const std::string &name, const std::string &letter);

std::unique_ptr<Store> open_hdf5(const std::string &path);
std::unique_ptr<Store> open_netcdf(const std::string &path);
std::unique_ptr<Store> open_zarr(const std::string &folder);
