/* SPDX-License-Identifier: MIT */
/* The build in slabs: the bytes of the build in memory, whatever the memory and the threads, and across a kill. */
#define _GNU_SOURCE
#include "folder.h"
#include "test.h"

#include <dirent.h>

#include "base/file.h"
#include "pyramid/pyramid_stream.h"
#include "scene/subject.h"

static iso_status open_path(void *user, iso_volume_source **source, iso_error *err)
{
    return iso_source_open(user, source, err);
}

static iso_volume make_volume(const size_t size[3], iso_type type, char *path)
{
    const double spacing[3] = {1, 0.75, 2.5};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    iso_volume v;
    assert_ok(iso_volume_create(&v, &g, type, "test", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i) {
        const unsigned h = (unsigned)(i * 2654435761u) >> 8;
        switch (type) {
        case ISO_U8: ((uint8_t *)v.data)[i] = (uint8_t)h; break;
        case ISO_U16: ((uint16_t *)v.data)[i] = (uint16_t)h; break;
        case ISO_I16: ((int16_t *)v.data)[i] = (int16_t)h; break;
        case ISO_F64: ((double *)v.data)[i] = h * 1e-3; break;
        default: ((float *)v.data)[i] = (float)h * 0.25f; break;
        }
    }
    assert_ok(iso_volume_save(&v, path, false, &err));
    iso_volume_destroy(&v);
    assert_ok(iso_volume_load(path, &v, &err)); /* with what the file's header adds, such as the unit */
    return v;
}

static size_t count_files(const char *dir)
{
    size_t count = 0;
    DIR *d = opendir(dir);
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d));)
        count += e->d_name[0] != '.';
    closedir(d);
    return count;
}

/* The name of the first file that differs, or NULL. */
static const char *first_difference(const char *a, const char *b)
{
    static char name[256];
    DIR *d = opendir(a);
    bool same = count_files(a) == count_files(b);
    snprintf(name, sizeof name, "number of files");
    for (struct dirent *e; d && same && (e = readdir(d));) {
        if (e->d_name[0] == '.')
            continue;
        FREED char *pa = iso_path_join(a, e->d_name), *pb = iso_path_join(b, e->d_name), *da = NULL, *db = NULL;
        size_t na = 0, nb = 0;
        snprintf(name, sizeof name, "%s", e->d_name);
        same = iso_file_read(pa, &da, &na, NULL) == ISO_OK && iso_file_read(pb, &db, &nb, NULL) == ISO_OK && na == nb &&
               memcmp(da, db, na) == 0;
    }
    closedir(d);
    return same ? NULL : name;
}

typedef struct job {
    size_t size[3];
    iso_type type;
    iso_scalar_filter scalar;
    iso_direction_filter direction;
    size_t levels, radius;
    bool keep;
    iso_gradient_method gradient;
} job;

static iso_pyramid_options options_of(const job *j)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = j->levels;
    opt.scalar_filter = j->scalar;
    opt.direction_filter = j->direction;
    opt.gauss_radius = j->radius;
    opt.keep_float = opt.keep_magnitude = j->keep;
    opt.gradient.method = j->gradient;
    opt.threads = 2;
    return opt;
}

static const job jobs[] = {
    {{17, 13, 23}, ISO_U16, ISO_SCALAR_MEAN, ISO_DIRECTION_MOMENTS, 4, 2, true, ISO_GRADIENT_CENTRAL},
    {{8, 9, 70}, ISO_F32, ISO_SCALAR_MEAN, ISO_DIRECTION_MOMENTS, 7, 2, false, ISO_GRADIENT_CENTRAL},
    {{12, 7, 41}, ISO_U8, ISO_SCALAR_GAUSS, ISO_DIRECTION_EQ1, 4, 2, true, ISO_GRADIENT_FOURTH},
    {{9, 10, 67}, ISO_I16, ISO_SCALAR_MEAN, ISO_DIRECTION_EQ1, 6, 3, false, ISO_GRADIENT_CENTRAL},
    {{10, 11, 37}, ISO_F64, ISO_SCALAR_GAUSS, ISO_DIRECTION_NAIVE, 3, 1, true, ISO_GRADIENT_SOBEL},
    {{5, 1, 33}, ISO_F64, ISO_SCALAR_GAUSS, ISO_DIRECTION_MOMENTS, 7, 4, false, ISO_GRADIENT_FOURTH},
    {{14, 9, 35}, ISO_U16, ISO_SCALAR_MEAN, ISO_DIRECTION_TENSOR, 6, 2, true, ISO_GRADIENT_CENTRAL},
    {{15, 6, 59}, ISO_U16, ISO_SCALAR_MEAN, ISO_DIRECTION_MOMENTS, 4, 2, false, ISO_GRADIENT_BSPLINE},
    {{9, 7, 133}, ISO_U8, ISO_SCALAR_LEAST_SQUARES, ISO_DIRECTION_MOMENTS, 3, 2, true, ISO_GRADIENT_CENTRAL},
    {{18, 5, 75}, ISO_F32, ISO_SCALAR_LEAST_SQUARES, ISO_DIRECTION_EQ1, 7, 2, false, ISO_GRADIENT_SOBEL},
    {{9, 6, 133}, ISO_F32, ISO_SCALAR_DAMPED, ISO_DIRECTION_MOMENTS, 7, 2, false, ISO_GRADIENT_CENTRAL},
    {{6, 11, 90}, ISO_I16, ISO_SCALAR_LEAST_SQUARES, ISO_DIRECTION_TENSOR, 7, 2, false, ISO_GRADIENT_CENTRAL},
    {{14, 9, 75}, ISO_U16, ISO_SCALAR_MEAN, ISO_DIRECTION_AUTO, 4, 2, true, ISO_GRADIENT_CENTRAL},
    {{8, 7, 91}, ISO_U8, ISO_SCALAR_LEAST_SQUARES, ISO_DIRECTION_AUTO, 7, 2, true, ISO_GRADIENT_CENTRAL},
    {{9, 7, 67}, ISO_F32, ISO_SCALAR_GAUSS, ISO_DIRECTION_AUTO, 7, 2, false, ISO_GRADIENT_BSPLINE},
    {{9, 11, 131}, ISO_U16, ISO_SCALAR_MEAN, ISO_DIRECTION_LEAST_SQUARES, 3, 2, true, ISO_GRADIENT_CENTRAL},
    {{7, 9, 75}, ISO_F32, ISO_SCALAR_DAMPED, ISO_DIRECTION_LEAST_SQUARES, 7, 2, false, ISO_GRADIENT_BSPLINE},
    {{1, 1, 1}, ISO_U8, ISO_SCALAR_MEAN, ISO_DIRECTION_MOMENTS, 4, 2, false, ISO_GRADIENT_CENTRAL},
    {{6, 5, 1}, ISO_U16, ISO_SCALAR_GAUSS, ISO_DIRECTION_EQ1, 1, 2, true, ISO_GRADIENT_CENTRAL},
};
#define JOB_COUNT (sizeof jobs / sizeof *jobs)

/* The pyramid as iso_pyramid_build and iso_pyramid_save make it. */
static void build_in_memory(const job *j, const iso_volume *v, const char *source, const char *dir)
{
    iso_pyramid_options opt = options_of(j);
    OWNED(iso_pyramid) p;
    assert_ok(iso_pyramid_build(v, source, &opt, &p, NULL, &err));
    assert_ok(iso_pyramid_save(&p, dir, &err));
}

static iso_stream_report stream(const job *j, char *source, const char *dir, int threads, iso_stream_options how,
                                iso_status wanted)
{
    iso_pyramid_options opt = options_of(j);
    opt.threads = threads;
    const iso_stream_input in = {open_path, source, source};
    iso_stream_report report;
    if (wanted == ISO_OK)
        assert_ok(iso_pyramid_stream(&in, &opt, &how, dir, &report, NULL, &err));
    else
        assert_status(iso_pyramid_stream(&in, &opt, &how, dir, &report, NULL, &err), wanted);
    return report;
}

static char *partial_of(const char *name)
{
    char text[64];
    snprintf(text, sizeof text, ".%s.partial", name);
    return iso_path_join(folder, text);
}

TEST(slabs_and_threads_give_the_bytes_of_the_build_in_memory)
{
    FREED char *source = iso_path_join(folder, "v.nrrd"), *a = iso_path_join(folder, "a.iso"),
               *b = iso_path_join(folder, "b.iso");
    for (size_t i = 0; i < JOB_COUNT; ++i) {
        OWNED(iso_volume) v = make_volume(jobs[i].size, jobs[i].type, source);
        build_in_memory(&jobs[i], &v, source, a);
        for (int threads = 1; threads <= 3; threads += 2) {
            for (size_t slab = 0; slab < 3; ++slab) {
                const iso_stream_options how = {.max_slab = slab == 0 ? 1 : slab == 1 ? 24 : 0, .direct = slab == 1};
                iso_stream_report r = stream(&jobs[i], source, b, threads, how, ISO_OK);
                const char *differs = first_difference(a, b);
                if (differs)
                    fail_msg("job %zu, %d threads, slabs of %zu planes: %s differs", i, threads, r.slab_planes,
                             differs);
                assert_true(slab > 0 || r.slab_planes <= 16);
            }
        }
    }
}

TEST(a_build_that_was_killed_is_taken_up_with_the_same_bytes)
{
    char *source = iso_path_join(folder, "v.nrrd"), *a = iso_path_join(folder, "a.iso"),
         *b = iso_path_join(folder, "c.iso");
    FREED char *partial = partial_of("c.iso");
    for (size_t i = 0; i < JOB_COUNT; ++i) {
        if (jobs[i].size[2] < 20)
            continue;
        OWNED(iso_volume) v = make_volume(jobs[i].size, jobs[i].type, source);
        build_in_memory(&jobs[i], &v, source, a);
        for (size_t stop = 1; stop < jobs[i].size[2] - 16; stop += 17) {
            iso_remove_tree(b);
            stream(&jobs[i], source, b, 2, (iso_stream_options){.max_slab = 1, .direct = stop % 2, .stop_after = stop},
                   ISO_E_PROGRAM);
            assert_false(iso_path_exists(b)); /* nothing looks finished */
            assert_true(iso_path_is_dir(partial));
            assert_false(iso_pyramid_is_one(partial));
            iso_stream_report r = stream(&jobs[i], source, b, 1, (iso_stream_options){.max_slab = 1, .resume = true},
                                         ISO_OK);
            assert_true(r.resumed_at_plane >= stop);
            assert_false(iso_path_exists(partial));
            const char *differs = first_difference(a, b);
            if (differs)
                fail_msg("job %zu, stopped after %zu planes: %s differs", i, stop, differs);
        }
    }
    free(source);
    free(a);
    free(b);
}

TEST(what_does_not_fit_is_not_taken_up)
{
    FREED char *source = iso_path_join(folder, "v.nrrd"), *a = iso_path_join(folder, "a.iso"),
               *b = iso_path_join(folder, "d.iso");
    job other = jobs[0];
    OWNED(iso_volume) v = make_volume(jobs[0].size, jobs[0].type, source);
    stream(&jobs[0], source, b, 2, (iso_stream_options){.max_slab = 1, .stop_after = 8}, ISO_E_PROGRAM);
    other.levels = 3;
    build_in_memory(&other, &v, source, a);
    iso_stream_report r = stream(&other, source, b, 2, (iso_stream_options){.resume = true}, ISO_OK);
    assert_int_equal(r.resumed_at_plane, 0);
    assert_null(first_difference(a, b));
    stream(&jobs[0], source, b, 2, (iso_stream_options){.max_slab = 1, .stop_after = 8}, ISO_E_PROGRAM);
    assert_null(first_difference(a, b)); /* the finished one stays until the new one is */
    r = stream(&jobs[0], source, b, 2, (iso_stream_options){0}, ISO_OK); /* without resume: anew */
    assert_int_equal(r.resumed_at_plane, 0);
}

TEST(files_shorter_than_the_progress_says_are_refused)
{
    FREED char *source = iso_path_join(folder, "v.nrrd"), *b = iso_path_join(folder, "e.iso"),
               *partial = partial_of("e.iso");
    OWNED(iso_volume) v = make_volume(jobs[0].size, jobs[0].type, source);
    stream(&jobs[0], source, b, 2, (iso_stream_options){.max_slab = 1, .stop_after = 8}, ISO_E_PROGRAM);
    FREED char *path = iso_path_join(partial, "level_0.nrrd");
    assert_ok(iso_file_write(path, "NRRD0004", 8, &err));
    stream(&jobs[0], source, b, 2, (iso_stream_options){.resume = true}, ISO_E_FORMAT);
    assert_false(iso_path_exists(b));
}

TEST(too_little_memory_is_refused_with_what_is_needed)
{
    FREED char *source = iso_path_join(folder, "v.nrrd"), *b = iso_path_join(folder, "f.iso");
    OWNED(iso_volume) v = make_volume(jobs[0].size, jobs[0].type, source);
    stream(&jobs[0], source, b, 2, (iso_stream_options){.memory_bytes = 1000}, ISO_E_MEMORY);
    assert_false(iso_path_exists(b));
}

TEST(voxels_without_data_are_streamed_with_the_same_bytes)
{
    FREED char *source = iso_path_join(folder, "v.nrrd"), *a = iso_path_join(folder, "a.iso"),
               *b = iso_path_join(folder, "h.iso");
    const job j = jobs[1];
    OWNED(iso_volume) v = make_volume(j.size, ISO_F32, source), loaded;
    for (size_t i = 0; i < 2000; ++i)
        ((float *)v.data)[7 * i % iso_geometry_voxel_count(&v.geometry)] = NAN;
    assert_ok(iso_volume_save(&v, source, false, &err));
    assert_ok(iso_volume_load(source, &loaded, &err));
    build_in_memory(&j, &loaded, source, a);
    stream(&j, source, b, 2, (iso_stream_options){.max_slab = 16}, ISO_OK);
    const char *differs = first_difference(a, b);
    if (differs)
        fail_msg("%s differs", differs);
}

TEST(an_infinite_value_is_refused_and_leaves_nothing)
{
    FREED char *source = iso_path_join(folder, "v.nrrd"), *b = iso_path_join(folder, "g.iso"),
               *partial = partial_of("g.iso");
    OWNED(iso_volume) v = make_volume(jobs[1].size, jobs[1].type, source);
    ((float *)v.data)[1000] = INFINITY;
    assert_ok(iso_volume_save(&v, source, false, &err));
    stream(&jobs[1], source, b, 2, (iso_stream_options){0}, ISO_E_RANGE);
    assert_false(iso_path_exists(b));
    assert_false(iso_path_exists(partial));
}

static const char *const names[] = {"pyramid.json", "level_*.nrrd", NULL};

static void write_in(const char *dir, const char *name)
{
    FREED char *path = iso_path_join(dir, name);
    assert_ok(iso_file_write(path, name, strlen(name), &err));
}

/* Else the next run would take it for its own, and remove it. */
TEST(a_file_that_somebody_puts_into_an_unfinished_folder_is_not_listed)
{
    FREED char *path = iso_path_join(folder, "h.iso");
    iso_output out;
    bool resumed;
    assert_ok(iso_output_resume_dir(&out, path, names, false, &resumed, &err));
    write_in(out.temp_path, "pyramid.json");
    write_in(out.temp_path, "paper.tex");
    assert_ok(iso_output_commit(&out, &err));
    assert_status(iso_output_resume_dir(&out, path, names, false, &resumed, &err), ISO_E_IO);
    FREED char *paper = iso_path_join(path, "paper.tex");
    assert_true(iso_path_is_file(paper));
}

TEST(nor_does_it_go_with_a_folder_that_is_abandoned)
{
    FREED char *path = iso_path_join(folder, "i.iso"), *partial = partial_of("i.iso");
    iso_output out;
    bool resumed;
    assert_ok(iso_output_resume_dir(&out, path, names, false, &resumed, &err));
    write_in(partial, "level_0.nrrd");
    write_in(partial, "paper.tex");
    iso_output_abandon(&out);
    FREED char *paper = iso_path_join(partial, "paper.tex"), *level = iso_path_join(partial, "level_0.nrrd");
    assert_true(iso_path_is_file(paper));
    assert_false(iso_path_exists(level));
}

static void assert_same_level(const iso_level *a, const iso_level *b)
{
    const size_t count = iso_geometry_voxel_count(&a->geometry);
    assert_memory_equal(a->geometry.size, b->geometry.size, sizeof a->geometry.size);
    assert_memory_equal(a->scalar, b->scalar, count * sizeof *a->scalar);
    assert_memory_equal(a->codes, b->codes, 3 * count);
}

/* Loads the coarse levels of a file or pyramid with more voxels than wanted, and compares them. */
static void assert_coarse_levels(const char *path, const iso_pyramid_options *opt, const iso_pyramid *whole,
                                 bool is_folder)
{
    const iso_volume_input input = {0};
    iso_subject_coarse coarse;
    {
        OWNED(iso_pyramid) outline, p;
        assert_ok(iso_subject_load_coarse(path, &input, opt, 100, NULL, &outline, &coarse, &err));
        assert_non_null(coarse.folder);
        assert_int_equal(outline.level_count, whole->level_count);
        for (size_t k = 0; k < whole->level_count; ++k)
            assert_null(outline.levels[k].scalar);
        assert_ptr_equal(iso_pyramid_finest(&outline), outline.levels);
        assert_ok(iso_pyramid_load_from(coarse.folder, 1, &p, &err));
        assert_null(p.levels[0].scalar);
        assert_null(p.levels[0].codes);
        assert_true(iso_pyramid_lo(&p) == iso_pyramid_lo(whole) && iso_pyramid_hi(&p) == iso_pyramid_hi(whole));
        assert_ptr_equal(iso_pyramid_finest(&p), &p.levels[1]);
        for (size_t k = 1; k < p.level_count; ++k)
            assert_same_level(&p.levels[k], &whole->levels[k]);
        OWNED(iso_view) view; /* a first picture, whose transfer function is chosen by level 1 */
        assert_ok(iso_subject_make_view(&(iso_subject_look){.size = "16"}, &p, &view, &err));
    }
    FREED char *temporary = coarse.temporary ? strdup(coarse.temporary) : NULL;
    assert_int_equal(temporary == NULL, is_folder);
    assert_true(!temporary || iso_path_exists(temporary));
    iso_subject_coarse_destroy(&coarse);
    assert_true(!temporary || !iso_path_exists(temporary));
}

TEST(of_a_large_volume_the_coarse_levels_are_built_and_loaded_alone)
{
    FREED char *source = iso_path_join(folder, "l.nrrd"), *dir = iso_path_join(folder, "l.iso");
    const size_t size[3] = {20, 17, 26};
    OWNED(iso_volume) v = make_volume(size, ISO_U8, source);
    OWNED(iso_pyramid) whole, all;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 3;
    assert_ok(iso_pyramid_build(&v, source, &opt, &whole, NULL, &err));
    assert_ok(iso_pyramid_save(&whole, dir, &err));
    assert_coarse_levels(source, &opt, &whole, false);
    assert_coarse_levels(dir, &opt, &whole, true);
    assert_true(iso_pyramid_is_one(dir)); /* the user's folder stays */
    iso_subject_coarse coarse;
    assert_ok(iso_subject_load_coarse(source, &(iso_volume_input){0}, &opt, 20 * 17 * 26, NULL, &all, &coarse, &err));
    assert_null(coarse.folder);
    assert_same_level(&all.levels[0], &whole.levels[0]);
}

TEST_MAIN(make_folder, remove_folder)
