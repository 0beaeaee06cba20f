/* SPDX-License-Identifier: MIT */
/* Renderers that a renderers.json names: what it says wrong is refused with the file, the row and the key; the program
 * that doc/guide/numpy_renderer.py passes every calibration; and each fault that is planted into its text fails the one
 * that is made for it. */
#define _GNU_SOURCE

#include "base/file.h"
#include "renderers/external.h"
#include "tests/folder.h"
#include "tests/test.h"
#include "validate/calibrate.h"

static iso_renderers renderers;

static void write_text(const char *name, const char *text)
{
    FREED char *path = iso_path_join(folder, name);
    assert_ok(iso_file_write(path, text, strlen(text), &err));
}

static iso_status load(const char *name, const char *text, iso_error *why)
{
    FREED char *path = iso_path_join(folder, name);
    write_text(name, text);
    const iso_status status = iso_renderers_load(path, why);
    return status;
}

/* ---- what a file says wrong ---- */

TEST(what_a_file_says_wrong_is_named)
{
#define ROW(more) "{\"schema\": \"isoshade.renderers/1\", \"renderers\": [{" more "}]}"
#define GOOD "\"name\": \"x\", \"command\": [\"true\"], \"tier\": \"limit\""
    const struct {
        const char *text, *words;
        iso_status status;
    } cases[] = {
        {"{", "bad.json", ISO_E_FORMAT},
        {"[]", "bad.json", ISO_E_FORMAT},
        {"{\"schema\": \"isoshade.scene/1\", \"renderers\": []}", "must be \"isoshade.renderers/1\"", ISO_E_FORMAT},
        {"{\"schema\": \"isoshade.renderers/1\"}", "renderers", ISO_E_FORMAT},
        {"{\"schema\": \"isoshade.renderers/1\", \"renderers\": [7]}", "renderer 1: must be an object", ISO_E_FORMAT},
        {ROW("\"command\": [\"true\"], \"tier\": \"limit\""), "renderer 1: \"name\"", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"tier\": \"limit\""), "renderer 1, x: \"command\"", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"command\": [\"true\"]"), "renderer 1, x: \"tier\"", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"command\": [], \"tier\": \"limit\""), "\"command\" is empty", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"command\": [7], \"tier\": \"limit\""), "is not a list of words", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"command\": \"true\", \"tier\": \"limit\""), "\"command\": is not a list",
         ISO_E_FORMAT},
        {ROW("\"name\": \"X y\", \"command\": [\"true\"], \"tier\": \"limit\""), "\"name\" must have", ISO_E_FORMAT},
        {ROW("\"name\": \"gl\", \"command\": [\"true\"], \"tier\": \"limit\""), "renderer \"gl\": this name is taken",
         ISO_E_USAGE},
        {ROW("\"name\": \"x\", \"command\": [\"true\"], \"tier\": \"float\""), "must be one of: samples, limit, 8 bits",
         ISO_E_FORMAT},
        {ROW(GOOD ", \"can\": [\"fog\"]"), "\"can\" has an unknown word", ISO_E_FORMAT},
        {ROW(GOOD ", \"colour\": \"#123456\""), "unknown key \"colour\"", ISO_E_FORMAT},
        {ROW(GOOD ", \"color\": \"red\""), "\"color\" is not like", ISO_E_FORMAT},
        {ROW(GOOD ", \"timeout_seconds\": 0"), "\"timeout_seconds\" is 0", ISO_E_RANGE},
        {ROW(GOOD ", \"seeds\": 99"), "\"seeds\" is 99", ISO_E_RANGE},
        {ROW(GOOD ", \"limits\": {\"rmse\": 0, \"max_abs\": 0}, \"why\": \"none\""), "\"limits\" is not for the tier",
         ISO_E_FORMAT},
        {ROW(GOOD ", \"bits\": 8"), "\"bits\" is not for the tier", ISO_E_FORMAT},
        {ROW(GOOD ", \"half\": true"), "\"half\" is for the tier \"samples\"", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"command\": [\"true\"], \"tier\": \"samples\", \"seeds\": 2"),
         "\"seeds\" is for the tier", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"command\": [\"true\"], \"tier\": \"8 bits\", \"limits\": {\"rmse\": 0, \"max_abs\": 0}"),
         "\"why\"", ISO_E_FORMAT},
        {ROW("\"name\": \"x\", \"command\": [\"true\"], \"tier\": \"8 bits\", \"why\": \"w\", \"limits\": {\"rmse\": 0.01, "
             "\"max_abs\": 0.2}"),
         "\"max_abs\" is 0.2, must be 0 to 0.05", ISO_E_RANGE},
    };
    const size_t before = iso_renderer_count();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        iso_error why = {""};
        const iso_status status = load("bad.json", cases[i].text, &why);
        if (status != cases[i].status || !strstr(why.text, cases[i].words))
            fail_msg("%s: status %d, \"%s\", wanted %d and \"%s\"", cases[i].text, status, why.text, cases[i].status,
                     cases[i].words);
        assert_non_null(strstr(why.text, "bad.json"));
    }
    assert_int_equal(iso_renderer_count(), before);
    iso_error why = {""};
    assert_int_equal(iso_renderers_load("/no/such/file.json", &why), ISO_E_IO);
    assert_non_null(strstr(why.text, "/no/such/file.json"));
}

TEST(limits_follow_from_the_tier)
{
    const iso_renderer_info *r;
    assert_ok(
        load("tiers.json",
             "{\"schema\": \"isoshade.renderers/1\", \"renderers\": ["
             "{\"name\": \"bits\", \"command\": [\"true\"], \"tier\": \"8 bits\", \"why\": \"w\","
             " \"limits\": {\"rmse\": 0.001, \"max_abs\": 0.002, \"sharp_max_abs\": 0.01}},"
             "{\"name\": \"half\", \"command\": [\"true\"], \"tier\": \"samples\", \"half\": true},"
             "{\"name\": \"noisy\", \"command\": [\"true\"], \"tier\": \"limit\", \"seeds\": 6, \"samples\": 9}]}",
             &err));
    assert_ok(iso_renderer_from_name("bits", &r, &err));
    assert_float_equal(r->lock_step->smooth.max_abs, 0.002 + 1.0 / 510, 1e-8);
    assert_float_equal(r->lock_step->sharp.max_abs, 0.01 + 1.0 / 510, 1e-8);
    assert_float_equal(r->lock_step->sharp.rmse, 0.001 + 1.0 / 510, 1e-8);
    assert_int_equal(r->lock_step->quadrature, ISO_QUADRATURE_CONVERGED);
    assert_false(iso_renderer_has(r, ISO_HAS_LIMIT));
    assert_ok(iso_renderer_from_name("half", &r, &err));
    assert_true(r->output.half);
    assert_float_equal(iso_half_rounding(1), 0x1p-12, 1e-9); /* of 1 - 2^-12, between two half floats */
    assert_float_equal(iso_half_rounding(1.5), 0x1p-11, 1e-8);
    assert_float_equal(iso_half_rounding(0), 0x1p-26, 1e-9);
    assert_ok(iso_renderer_from_name("noisy", &r, &err));
    assert_true(iso_renderer_has(r, ISO_HAS_LIMIT | ISO_IS_RANDOM | ISO_READS_SEED | ISO_READS_SAMPLES | ISO_IS_NAMED));
    assert_int_equal(r->seeds, 6);
    assert_int_equal(r->defaults.samples, 9);
    assert_null(r->lock_step);
    bool wanted[ISO_MAX_RENDERERS];
    assert_ok(iso_renderers_from_list(NULL, wanted, &err));
    assert_false(wanted[iso_renderer_index(r)]); /* never by default */
    assert_ok(iso_renderers_from_list("noisy", wanted, &err));
    assert_true(wanted[iso_renderer_index(r)]);
}

/* ---- the example program ---- */

/* What is planted: in the text of the program, `from` becomes `to`. `mistake`: its name (validate/mistakes.c), for
 * planted.py, which reads this table. */
static const struct {
    const char *what, *from, *to, *check, *mistake;
} faults[] = {
    {"half a voxel off", "np.clip(p - 0.5, 0, last)", "np.clip(p, 0, last)", "placement",
     "the volume stood half a voxel off toward -x, -y, -z"},
    {"mirrored along x", "grid[z, y, x]", "grid[z, y, last[0] - x]", "placement", "the volume were mirrored along x"},
    {"the volume of another day", "np.concatenate(grids, 3)", "np.concatenate(grids, 3)[::-1, ::-1, ::-1]", "placement",
     "the voxels were stored in reverse order"},
    {"rows from the bottom", "picture.astype", "picture[::-1].astype", "placement",
     "the first row were the bottom one"},
    {"half a pixel off", "(2 * np.arange(w) + 1 - w)", "(2 * np.arange(w) - w)", "placement",
     "rays passed half a pixel to the left"},
    {"extinction for 10 % more length", "np.expm1(-sigma", "np.expm1(-1.1 * sigma", "slab",
     "extinction were for 10 % more length"},
    {"multiplied by alpha twice", "    return rgba.reshape(",
     "    rgba[:, :3] *= rgba[:, 3:]\n    return rgba.reshape(", "slab", "color were multiplied by alpha twice"},
    {"not multiplied by alpha", "    return rgba.reshape(",
     "    rgba[:, :3] /= np.maximum(rgba[:, 3:], 1e-9)\n    return rgba.reshape(", "slab",
     "color were not multiplied by alpha"},
    {"a picture in sRGB", "picture.astype", "(picture ** (1 / 2.2)).astype", "slab",
     "the picture and its alpha had a gamma of 2.2"},
    {"channels in another order", "picture.astype", "picture[..., [2, 1, 0, 3]].astype", "slab",
     "red and blue were exchanged"},
    {"colors taken for sRGB", "np.column_stack((tf['color'],", "np.column_stack((np.power(tf['color'], 2.2),",
     "transfer function", "the TF's colors were taken for values with a gamma of 2.2"},
    {"the range is off by an entry", "np.linspace(tf['lo'], tf['hi'],", "np.linspace(tf['lo'], tf['hi'] + 1 / 16,",
     "transfer function", "the TF's range were off by one entry"},
    {"another level", "    last = np.array(grid.shape[2::-1])",
     "    fine = np.pad(grid, [(0, n % 2) for n in grid.shape[:3]] + [(0, 0)], 'edge')\n"
     "    grid, p = sum(fine[i::2, j::2, k::2] for i, j, k in np.ndindex(2, 2, 2)) / 8, p / 2\n"
     "    last = np.array(grid.shape[2::-1])",
     "transfer function", "voxels were those of the next coarser level"},
    {"axes exchanged", "shade(r, field[:, 1:],", "shade(r, field[:, [2, 1, 3]],", "light",
     "x and y of the directions were exchanged"},
    {"gradients by the matrix itself", "shade(r, field[:, 1:],",
     "shade(r, field[:, 1:] @ np.array(v['index_to_world'])[:, :3] @ np.array(v['index_to_world'])[:, :3].T,", "light",
     "gradients went to the world by the matrix itself"},
    {"the light from the other side", "np.abs(n @ l['direction'])",
     "np.abs(n @ (l['direction'] * np.array((-1, 1, 1))))", "light", "diffuse light came from the mirrored side"},
    {"lit on one side", "np.abs(n @ l['direction'])", "np.maximum(n @ l['direction'], 0)", "light",
     "diffuse light were one-sided"},
    {"clipped at 1", "picture.astype", "np.minimum(picture, 1).astype", "light", "the picture were clipped at 1"},
    {"back before front", "((a + b) / 2)[i, None]", "(t0 + t1 - (a + b) / 2)[i, None]", "order",
     "back and front were exchanged along the ray"},
    {"the view vector of the other projection", "-ray[i])", "-np.broadcast_to(c['forward'], ray[i].shape))",
     "view vector", "highlights had one view vector for all pixels"},
    {"not normalized after filtering", "d / np.sqrt((d * d).sum(1) + r['directions']['epsilon'] ** 2)[:, None]", "d",
     "interpolation", "directions were not normalized after filtering"},
};
enum { FAULT_COUNT = sizeof faults / sizeof *faults };

/* The renderer that users start from; to be freed. */
static char *example_program(void)
{
    FREED char *file;
    size_t size;
    assert_ok(iso_file_read("doc/guide/numpy_renderer.py", &file, &size, &err));
    char *text = strndup(file, size);
    return text;
}

static char *changed(const char *text, const char *from, const char *to)
{
    const char *at = strstr(text, from);
    if (!at)
        fail_msg("the example has no \"%s\"", from);
    char *out = malloc(strlen(text) + strlen(to) + 1);
    sprintf(out, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    return out;
}

/* Debian's own where another one, without numpy, comes first in the PATH; NULL: none has it. */
static const char *python(void)
{
    static const char *const all[] = {"python3", "/usr/bin/python3"};
    char command[100];
    for (int i = 0; i < 2; ++i) {
        snprintf(command, sizeof command, "%s -c 'import numpy' 2>/dev/null", all[i]);
        if (system(command) == 0)
            return all[i];
    }
    return NULL;
}

/* "right", and "fault0" to the last. Not "numpy": a numpy.py would be imported for it. */
static void load_programs(const char *interpreter)
{
    FREED char *text = example_program(), *json = NULL;
    char name[32];
    size_t size;
    FILE *f = open_memstream(&json, &size);
    fputs("{\"schema\": \"isoshade.renderers/1\", \"renderers\": [", f);
    for (int i = -1; i < FAULT_COUNT; ++i) {
        FREED char *program = i < 0 ? strdup(text) : changed(text, faults[i].from, faults[i].to);
        snprintf(name, sizeof name, i < 0 ? "right" : "fault%d", i);
        fprintf(f,
                "%s{\"name\": \"%s\", \"command\": [\"%s\", \"%s.py\"], \"tier\": \"samples\", "
                "\"can\": [\"lights\", \"orthographic\", \"clip planes\"], \"timeout_seconds\": 300}",
                i < 0 ? "" : ",\n", name, interpreter, name);
        strcat(name, ".py");
        write_text(name, program);
    }
    fputs("]}", f);
    fclose(f);
    assert_ok(load("programs.json", json, &err));
}

TEST(the_program_passes_and_each_fault_in_it_is_found)
{
    const char *interpreter = python();
    const iso_renderer_info *r;
    iso_calibration c[ISO_CALIBRATION_COUNT];
    size_t made;
    char name[32];
    if (!interpreter)
        skip();
    load_programs(interpreter);
    assert_ok(iso_renderer_from_name("right", &r, &err));
    assert_ok(iso_calibrate(&renderers, r, NULL, c, &made, &err));
    for (size_t i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        if (!c[i].passed)
            fail_msg("%s: %g, at most %g", c[i].check, c[i].value, c[i].limit);
    for (int i = 0; i < FAULT_COUNT; ++i) {
        snprintf(name, sizeof name, "fault%d", i);
        assert_ok(iso_renderer_from_name(name, &r, &err));
        assert_ok(iso_calibrate_check(&renderers, r, NULL, iso_calibration_number(faults[i].check), &c[0], &err));
        if (c[0].passed)
            fail_msg("%s passes the check %s: %g, at most %g", faults[i].what, faults[i].check, c[0].value, c[0].limit);
    }
}

TEST_MAIN(make_folder, remove_folder)
