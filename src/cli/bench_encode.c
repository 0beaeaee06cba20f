/* bench_encode.c - direction codes: speed beside error. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "cli/bench.h"
#include "encode/code.h"

typedef struct scheme_result {
    double encode_million_per_second, decode_million_per_second, max_error_deg, mean_error_deg;
} scheme_result;

static double uniform(uint64_t *state)
{
    *state ^= *state << 13, *state ^= *state >> 7, *state ^= *state << 17;
    return (double)(*state >> 11) * 0x1p-53;
}

static void random_directions(float *directions, size_t count)
{
    uint64_t state = 20170613;
    for (size_t i = 0; i < count; ++i) {
        double z = 2 * uniform(&state) - 1, phi = 6.283185307179586 * uniform(&state), r = sqrt(1 - z * z);
        directions[3 * i] = (float)(r * cos(phi));
        directions[3 * i + 1] = (float)(r * sin(phi));
        directions[3 * i + 2] = (float)z;
    }
}

static void measure(iso_code code, const float *directions, uint8_t *bytes, float *decoded, size_t count,
                    scheme_result *r)
{
    double encode = INFINITY, decode = INFINITY;
    for (int run = 0; run < 5; ++run) {
        double start = iso_clock_seconds();
        iso_code_encode(code, directions, bytes, count);
        double middle = iso_clock_seconds();
        iso_code_decode_all(code, bytes, decoded, count);
        encode = fmin(encode, middle - start);
        decode = fmin(decode, iso_clock_seconds() - middle);
    }
    *r = (scheme_result){.encode_million_per_second = 1e-6 * (double)count / encode,
                         .decode_million_per_second = 1e-6 * (double)count / decode};
    for (size_t i = 0; i < count; ++i) {
        const float *a = directions + 3 * i, *b = decoded + 3 * i;
        double dot = 0, aa = 0, bb = 0;
        for (int c = 0; c < 3; ++c)
            dot += (double)a[c] * b[c], aa += (double)a[c] * a[c], bb += (double)b[c] * b[c];
        double error = 57.29577951308232 * atan2(sqrt(fmax(aa * bb - dot * dot, 0)), dot);
        r->mean_error_deg += error / (double)count;
        r->max_error_deg = fmax(r->max_error_deg, error);
    }
}

static void report(const iso_cli *cli, const scheme_result *results, size_t count)
{
    if (!cli->json)
        printf("%-10s %8s %8s %10s %10s\n", "code", "enc M/s", "dec M/s", "mean deg", "max deg");
    json_t *root = iso_cli_json(cli), *schemes = json_array();
    json_object_set_new(json_object_get(root, "options"), "count", json_integer((json_int_t)count));
    for (int c = 0; c < ISO_CODE_COUNT; ++c) {
        const scheme_result *r = &results[c];
        const char *name = iso_code_describe(c)->name;
        json_array_append_new(schemes, json_pack("{s:s, s:i, s:f, s:f, s:f, s:f}", "name", name, "bytes", 3,
                                                 "encode_million_per_second", r->encode_million_per_second,
                                                 "decode_million_per_second", r->decode_million_per_second,
                                                 "max_error_deg", r->max_error_deg, "mean_error_deg", r->mean_error_deg));
        if (!cli->json)
            printf("%-10s %8.1f %8.1f %10.4f %10.4f\n", name, r->encode_million_per_second,
                   r->decode_million_per_second, r->mean_error_deg, r->max_error_deg);
    }
    json_object_set_new(root, "schemes", schemes);
    if (cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    int count = 100000;
    struct poptOption options[] = {
        {"count", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &count, 0, "random directions", "N"},
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    scheme_result results[ISO_CODE_COUNT];
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 0, 0, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = iso_cli_check_range("--count", count, 1, 1e8, err);
    if (status == ISO_OK && next == ISO_CLI_RUN) {
        size_t n = (size_t)count;
        float *directions = malloc(6 * n * sizeof *directions);
        uint8_t *bytes = malloc(6 * n);
        if (!directions || !bytes) {
            status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu directions", n);
        } else {
            random_directions(directions, n);
            for (int c = 0; c < ISO_CODE_COUNT; ++c)
                measure(c, directions, bytes, directions + 3 * n, n, &results[c]);
            report(&cli, results, n);
        }
        free(directions);
        free(bytes);
    }
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_bench_encode = {
    .name = "bench encode",
    .summary = "direction codes: speed, holes, errors at voxels and between them",
    .usage = "[options]",
    .examples = "isoshade bench encode --count 100000\n",
    .run = run,
};
