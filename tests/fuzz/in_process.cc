/* SPDX-License-Identifier: MIT */
/* in_process.cc - a reader that is a program of its own, called within this process: to start a program takes a hundred
 * times as long as most damaged files take to be refused. Linked with the objects of one such program but its main(), in
 * place of src/volume/child_start.c. What the reader writes goes to a file in memory, from which it is read as from the
 * program's output. */
#include <sys/mman.h>

extern "C" {
#include "volume/child_start.h"
/* tests/fuzz/fuzz.h, which is no C++. */
extern const bool fuzz_reader_may_end;
const bool fuzz_reader_may_end = true;
}
#include "volume/child_writer.h"

namespace {

/* A header may promise any number of samples: so much is written, then nobody reads any more. */
enum { MOST_BYTES = 64 << 20 };

struct Output {
    int fd;
    size_t written;
};

ssize_t take(void *cookie, const char *data, size_t bytes)
{
    Output *output = static_cast<Output *>(cookie);
    if (output->written + bytes > MOST_BYTES)
        return 0;
    output->written += bytes;
    return write(output->fd, data, bytes);
}

} // namespace

extern "C" iso_status iso_child_start(iso_child_process *process, const char *const words[], iso_error *err)
{
    Output output{memfd_create("output", MFD_CLOEXEC), 0};
    cookie_io_functions_t functions{};
    functions.write = take;
    FILE *out = output.fd >= 0 ? fopencookie(&output, "wb", functions) : nullptr;
    *process = iso_child_process{0, nullptr};
    if (!out)
        return iso_fail(err, ISO_E_MEMORY, "%s: no file in memory", words[1]);
    if (!strstr(words[0], FUZZ_PROGRAM))
        return iso_fail(err, ISO_E_MISSING, "%s is asked for, and this is " FUZZ_PROGRAM, words[0]);
    limit_memory(words[1]);
    write_volume(child_program, words[1], {words[2], std::stoul(words[3]), std::stoul(words[4])}, out);
    fclose(out);
    lseek(output.fd, 0, SEEK_SET);
    process->output = fdopen(output.fd, "rb");
    return process->output ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", words[1]);
}
