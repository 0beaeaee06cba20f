/* SPDX-License-Identifier: MIT */
#include "vdb/vdb_nanovdb.h"
#include "vdb/vdb_guarded.h"

#if __has_include(<nanovdb/NanoVDB.h>)

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#if __has_include(<nanovdb/tools/CreateNanoGrid.h>) /* since OpenVDB 12 */
#define NANOVDB_USE_OPENVDB
#include <nanovdb/io/IO.h>
#include <nanovdb/tools/CreateNanoGrid.h>
#else
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#endif

namespace {

using handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

template <typename Grid> handle to_nanovdb(const Grid &grid)
{
#ifdef NANOVDB_USE_OPENVDB
    return nanovdb::tools::createNanoGrid(grid, nanovdb::tools::StatsMode::All, nanovdb::CheckMode::Full);
#else
    return nanovdb::openToNanoVDB(grid, nanovdb::StatsMode::All, nanovdb::ChecksumMode::Full);
#endif
}

/* Appends a text to a grid without other blind data: NanoVDB has no metadata. A reader finds it by the name. */
template <typename Value> handle add_blind_text(handle grid, const char *name, const std::string &text)
{
    const std::size_t at = grid.size(), bytes = (sizeof(nanovdb::GridBlindMetaData) + text.size() + 32) / 32 * 32;
    auto buffer = nanovdb::HostBuffer::create(at + bytes);
    std::memcpy(buffer.data(), grid.data(), at);
    std::memset(buffer.data() + at, 0, bytes); /* ends the texts, too */
    auto *head = reinterpret_cast<nanovdb::GridData *>(buffer.data());
    auto *note = reinterpret_cast<nanovdb::GridBlindMetaData *>(buffer.data() + at);
    head->mGridSize = at + bytes;
    head->mBlindMetadataOffset = static_cast<std::int64_t>(at);
    head->mBlindMetadataCount = 1;
    note->mSemantic = nanovdb::GridBlindDataSemantic::Unknown;
    note->mDataClass = nanovdb::GridBlindDataClass::Unknown;
    note->mDataType = nanovdb::GridType::Unknown;
    std::strcpy(note->mName, name);
    note->setBlindData(note + 1);
    std::memcpy(note + 1, text.data(), text.size());
    handle noted(std::move(buffer));
#ifdef NANOVDB_USE_OPENVDB
    note->mValueCount = text.size() + 1;
    note->mValueSize = 1;
    nanovdb::tools::updateChecksum(head, nanovdb::CheckMode::Full);
#else
    note->mElementCount = text.size() + 1;
    nanovdb::updateChecksum(*noted.grid<Value>(), nanovdb::ChecksumMode::Full);
#endif
    return noted;
}

template <typename Value, typename Grid> handle convert_noted(const Grid &grid, const std::string &values)
{
    return values.empty() ? to_nanovdb(grid) : add_blind_text<Value>(to_nanovdb(grid), "isoshade_values", values);
}

/* values: a note on all values, or empty. */
handle convert(const openvdb::GridBase::Ptr &grid, const std::string &values)
{
    if (const auto scalars = openvdb::gridPtrCast<openvdb::FloatGrid>(grid))
        return convert_noted<float>(*scalars, values);
    if (const auto vectors = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid)) {
        vectors->setGridClass(openvdb::GRID_UNKNOWN); /* NanoVDB allows fog volumes for one channel only */
        return convert_noted<nanovdb::Vec3f>(*vectors, values);
    }
    throw std::runtime_error("grid \"" + grid->getName() + "\" has values of type " + grid->valueType() +
                             ", must be float or vec3s");
}

/* Reads the grids of a file that this process has just written: any error is due to the disk. OpenVDB holds one grid at
 * a time. */
std::vector<handle> read_again(const char *vdb_path)
{
    std::vector<handle> grids;
    openvdb::io::File file(vdb_path);
    const auto read = [](auto what) {
        try {
            return what();
        } catch (const std::bad_alloc &) {
            throw;
        } catch (const std::exception &e) {
            throw openvdb::IoError(std::string("cannot be read back: ") + e.what());
        }
    };
    read([&] { return file.open(/*delayLoad=*/false); });
    const auto about = read([&] { return file.getMetadata(); });
    const auto values = about->getMetadata<openvdb::StringMetadata>("values");
    for (auto name = file.beginName(); name != file.endName(); ++name)
        grids.push_back(convert(read([&] { return file.readGrid(name.gridName()); }), values ? values->value() : ""));
    /* OpenVDB lists names by their letters; many programs take the first grid. */
    std::stable_partition(grids.begin(), grids.end(), [](const handle &grid) {
        return std::strncmp(grid.gridMetaData()->shortGridName(), "density", 7) == 0;
    });
    return grids;
}

} // namespace

int iso_vdb::to_nanovdb(const char *vdb_path, const char *path, iso_vdb_message *message)
{
    return iso_vdb::guarded(message, [&] {
        openvdb::initialize();
        const std::vector<handle> grids = read_again(vdb_path);
        std::ofstream out;
        out.exceptions(std::ios::failbit | std::ios::badbit);
        out.open(path, std::ios::out | std::ios::binary | std::ios::trunc);
        nanovdb::io::writeGrids<nanovdb::HostBuffer, std::vector>(out, grids, nanovdb::io::Codec::NONE);
        out.close();
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

const char *iso_vdb::nanovdb_version()
{
#define NUMBERS_AS_TEXT(a, b, c) #a "." #b "." #c
#define VERSION_TEXT(a, b, c) NUMBERS_AS_TEXT(a, b, c)
    return VERSION_TEXT(NANOVDB_MAJOR_VERSION_NUMBER, NANOVDB_MINOR_VERSION_NUMBER, NANOVDB_PATCH_VERSION_NUMBER);
}

#else /* built without the headers */

int iso_vdb::to_nanovdb(const char *, const char *, iso_vdb_message *)
{
    return ISO_OPENVDB_FAILED;
}

const char *iso_vdb::nanovdb_version()
{
    return nullptr;
}

#endif
