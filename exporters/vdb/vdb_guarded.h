/* SPDX-License-Identifier: MIT */
/* vdb_guarded.h - the only place that catches exceptions of OpenVDB; private to the C++ files of this folder. */
#pragma once

#include <cstdio>
#include <exception>
#include <ios>
#include <new>

#include <openvdb/Exceptions.h>

#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

/* Returns the result of `work`, or the status and the text of its exception. */
template <typename Work> int guarded(iso_vdb_message *message, Work work)
{
    int status = ISO_OPENVDB_FAILED;
    const char *what = "unknown failure";
    try {
        return work();
    } catch (const openvdb::IoError &e) {
        status = ISO_OPENVDB_IO;
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
        return status;
    } catch (const std::ios_base::failure &e) {
        status = ISO_OPENVDB_IO;
        what = "writing failed (is the disk full?)";
    } catch (const std::bad_alloc &) {
        status = ISO_OPENVDB_MEMORY;
        what = "out of memory";
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
        return status;
    } catch (...) {
    }
    std::snprintf(message->text, sizeof message->text, "%s", what);
    return status;
}

} // namespace iso_vdb
