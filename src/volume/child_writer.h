/* SPDX-License-Identifier: MIT */
/* child_writer.h - common code of the programs that read volumes for isoshade (child_stream.h), in C++. */
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "volume/child_stream.h"

/* An error, with the one line that a person reads. */
struct Failure {
    iso_status status;
    std::string text;
};

[[noreturn]] inline void fail(iso_status status, const std::string &text)
{
    throw Failure{status, text};
}

inline size_t bytes_of(iso_type type)
{
    switch (type) {
    case ISO_U8:
    case ISO_I8: return 1;
    case ISO_U16:
    case ISO_I16: return 2;
    case ISO_F64: return 8;
    default: return 4;
    }
}

/* A header, and the planes in their order. Both throw Failure, or an exception of their library. */
class PlaneReader {
public:
    iso_child_header header{};
    PlaneReader()
    {
        header.slope = 1;
    }
    virtual ~PlaneReader() = default;
    virtual void read_plane(char *out, size_t bytes) = 0;
};

/* The part of a file to read. */
struct Wanted {
    std::string part; /* "": the only one */
    size_t frame = 0, channel = 0;
    size_t uneven = ISO_UNEVEN_REFUSE;
};

struct ChildProgram {
    std::unique_ptr<PlaneReader> (*open)(const std::string &path, const Wanted &wanted);
    /* Returns the text of an exception of the library. */
    std::string (*cause)(const std::exception &e);
};

/* The program's own. */
extern const ChildProgram child_program;

/* Returns a library's message as one short line of plain text: it may quote bytes of a damaged file. */
inline std::string plain(const std::string &message)
{
    const size_t most = 200;
    std::string text;
    for (size_t i = 0; i < message.size() && text.size() <= most; ++i) { /* of which a damaged length may make megabytes */
        const char c = message[i];
        const bool is_plain = c > ' ' && c < 127;
        if (is_plain || (!text.empty() && text.back() != ' '))
            text += is_plain ? c : ' ';
    }
    return text.size() <= most ? text : text.substr(0, most) + " ...";
}

/* Runs work that may throw. */
template <typename Work> iso_child_answer guarded(const ChildProgram &program, const std::string &path, Work work)
{
    iso_child_answer answer{};
    std::string text;
    try {
        work();
    } catch (const Failure &f) {
        answer.status = f.status, text = f.text;
    } catch (const std::bad_alloc &) {
        answer.status = ISO_E_MEMORY, text = path + ": out of memory, or damaged: it asks for more than a file of its size may";
    } catch (const std::exception &e) {
        answer.status = ISO_E_FORMAT, text = path + ": " + plain(program.cause(e));
    }
    for (char &c : text)
        c = c == '\n' ? ' ' : c;
    snprintf(answer.error.text, sizeof answer.error.text, "%s", text.c_str());
    return answer;
}

/* Writes the bytes. False if the reader has closed the pipe. */
inline bool put(FILE *out, const void *data, size_t bytes)
{
    return fwrite(data, 1, bytes, out) == bytes;
}

/* ---- a limit of memory, which a damaged header may ask any amount of ---- */

/* Returns the bytes of a file, or of a folder's files; stops adding when the sum exceeds `most`. */
inline double bytes_of_input(const std::string &path, double most)
{
    namespace fs = std::filesystem;
    std::error_code failed;
    double bytes = static_cast<double>(fs::file_size(path, failed));
    if (!failed)
        return bytes;
    bytes = 0;
    fs::recursive_directory_iterator at(path, failed);
    for (; !failed && bytes <= most && at != fs::recursive_directory_iterator(); at.increment(failed)) {
        std::error_code is_none;
        const std::uintmax_t size = at->file_size(is_none);
        bytes += is_none ? 0 : static_cast<double>(size);
    }
    return bytes;
}

/* Memory of a library itself, without the stacks of its threads. */
constexpr double own_memory = 192e6;

/* Returns the memory limit by the file's size. Deflate packs at most 1032 bytes into one; libraries hold unpacked
 * data up to three times, and have a stack for each core. At most the machine's memory. */
inline rlim_t memory_for(const std::string &path)
{
    const double base = own_memory + 16e6 * static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN)), a_byte = 3100,
                 machine = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
    return static_cast<rlim_t>(std::min(machine, base + a_byte * bytes_of_input(path, machine / a_byte)));
}

inline rlim_t memory_limit; /* 0: none was set */

/* Limits writable memory, not addresses: threads reserve more of these than they use. */
inline void limit_memory(rlim_t bytes)
{
    rlimit limit{};
    getrlimit(RLIMIT_DATA, &limit);
    limit.rlim_cur = memory_limit = std::min(limit.rlim_max, bytes);
    setrlimit(RLIMIT_DATA, &limit);
}

/* Raises the memory limit by `bytes`, if a reader has its own bound that does not depend on the file's size. */
inline void allow_memory(size_t bytes)
{
    if (memory_limit > 0)
        limit_memory(memory_limit + bytes);
}

/* ---- a limit of time, for libraries that a damaged file keeps busy ----
 *
 * OpenVDB counts nodes up to 2^32 that a file does not have; HDF5 follows a heap whose parts have no length for ever. */

inline const void *late_answer; /* written at the time limit */
inline size_t late_bytes;
inline int late_output = -1;

extern "C" inline void answer_late(int)
{
    const char *from = static_cast<const char *>(late_answer);
    for (size_t left = late_bytes; left > 0;) {
        const ssize_t n = write(late_output, from, left);
        if (n <= 0)
            break;
        from += n;
        left -= static_cast<size_t>(n);
    }
    _exit(ISO_E_FORMAT);
}

/* A limit of processor time in seconds while it lives. At the limit the output ends with `answer`, which holds
 * `refusal`. No other output may wait to be written. */
class TimeLimit {
public:
    template <typename Answer>
    TimeLimit(const std::string &path, const char *what, double seconds, Answer &answer, iso_child_answer &refusal)
    {
        rlimit limit{};
        rusage used{};
        getrlimit(RLIMIT_CPU, &limit);
        getrusage(RUSAGE_SELF, &used);
        const rlim_t now = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
        limit.rlim_cur = now + 1 + static_cast<rlim_t>(seconds);
        refusal.status = ISO_E_FORMAT;
        snprintf(refusal.error.text, sizeof refusal.error.text,
                 "%.300s: damaged? not %s after %.0f s of processor time, which is too long for its size", path.c_str(), what,
                 seconds);
        late_answer = &answer;
        late_bytes = sizeof answer;
        signal(SIGXCPU, answer_late);
        setrlimit(RLIMIT_CPU, &limit);
    }
    TimeLimit(const TimeLimit &) = delete;
    TimeLimit &operator=(const TimeLimit &) = delete;
    ~TimeLimit()
    {
        rlimit limit{};
        getrlimit(RLIMIT_CPU, &limit);
        limit.rlim_cur = limit.rlim_max;
        setrlimit(RLIMIT_CPU, &limit);
    }
};

/* ---- the whole ---- */

/* Limits for a small file. A plane may need all of a file again, where its parts reach through many. Tests have
 * less. */
#ifndef ISO_OPEN_SECONDS
#define ISO_OPEN_SECONDS 4
#define ISO_PLANE_SECONDS 20
#endif

inline int write_volume(const ChildProgram &program, const char *path, const Wanted &wanted, FILE *out)
{
    constexpr double bytes_a_second = 4e6, most_bytes = 4e9; /* libraries read far more a second, packed or not */
    const double bytes = bytes_of_input(path, most_bytes);
    std::unique_ptr<PlaneReader> reader;
    iso_child_header header{}, late{};
    iso_child_answer answer{}, late_plane{};
    std::vector<char> plane;
    snprintf(late.version, sizeof late.version, "%s", ISO_VERSION);
    {
        const TimeLimit limit(path, "opened", ISO_OPEN_SECONDS + bytes / bytes_a_second, late, late.answer);
        answer = guarded(program, path, [&] {
            reader = program.open(path, wanted);
            header = reader->header;
            plane.resize(header.size[0] * header.size[1] * bytes_of(header.type));
        });
    }
    header.answer = answer;
    memcpy(header.version, late.version, sizeof header.version);
    if (!put(out, &header, sizeof header) || fflush(out) != 0 || answer.status != ISO_OK)
        return answer.status;
    const double seconds = ISO_PLANE_SECONDS + (bytes + static_cast<double>(plane.size())) / bytes_a_second;
    for (size_t z = 0; z < header.size[2] && answer.status == ISO_OK; ++z) {
        {
            const TimeLimit limit(path, "read", seconds, late_plane, late_plane);
            answer = guarded(program, path, [&] { reader->read_plane(plane.data(), plane.size()); });
        }
        if (!put(out, &answer, sizeof answer) || (answer.status == ISO_OK && !put(out, plane.data(), plane.size())) ||
            fflush(out) != 0)
            return ISO_E_IO;
    }
    const TimeLimit limit(path, "closed", seconds, late_plane, late_plane);
    reader.reset();
    return answer.status;
}

/* Runs PROGRAM PATH PART FRAME CHANNEL UNEVEN, which only isoshade starts. Redirects what libraries print: the output
 * carries samples. */
inline int run_child(const ChildProgram &program, int argc, char **argv)
{
    FILE *out = fdopen(dup(STDOUT_FILENO), "wb");
    if (argc != 6 || !out || !freopen("/dev/null", "w", stdout))
        return ISO_E_USAGE;
    limit_memory(memory_for(argv[1]));
    late_output = fileno(out);
    return write_volume(program, argv[1], {argv[2], std::stoul(argv[3]), std::stoul(argv[4]), std::stoul(argv[5])},
                        out);
}
