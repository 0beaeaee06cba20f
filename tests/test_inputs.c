/* SPDX-License-Identifier: MIT */
/* Files that one command reads and writes: known by what they are, not by their names. */
#define _GNU_SOURCE
#include "test.h"

#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inputs.h"

/* Temporaries of this process, as those of folder.h are, are no inputs. */
static char *folder;

static int make_folder(void **state)
{
    (void)state;
    const char *base = getenv("TMPDIR");
    return asprintf(&folder, "%s/inputs-XXXXXX", base && *base ? base : "/tmp") > 0 && mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    iso_remove_tree(folder);
    free(folder);
    return 0;
}

static char *make_file(const char *name)
{
    char *path = iso_path_join(folder, name);
    assert_ok(iso_file_write(path, name, strlen(name), &err));
    return path;
}

/* The first test: nothing is watched yet. */
TEST(a_program_may_save_what_it_has_loaded)
{
    FREED char *path = make_file("a");
    assert_ok(iso_inputs_note(path, &err));
    assert_ok(iso_file_write(path, "b", 1, &err));
    iso_inputs_watch();
}

TEST(an_output_that_was_announced_is_no_input)
{
    FREED char *path = make_file("b"), *link = iso_path_join(folder, "link");
    assert_int_equal(symlink(path, link), 0);
    assert_ok(iso_inputs_announce(path, &err));
    assert_status(iso_inputs_note(link, &err), ISO_E_USAGE);
}

TEST(nor_is_an_input_an_output_later)
{
    FREED char *path = make_file("c"), *other = iso_path_join(folder, "hard");
    assert_int_equal(link(path, other), 0);
    assert_ok(iso_inputs_note(path, &err));
    assert_ok(iso_inputs_note(path, &err));
    assert_status(iso_inputs_announce(other, &err), ISO_E_USAGE);
    assert_status(iso_inputs_check(other, &err), ISO_E_USAGE);
    assert_status(iso_file_write(other, "", 0, &err), ISO_E_USAGE);
}

/* Also one that is not there yet, by a link to the folder, and one that was announced before. */
TEST(nothing_in_a_folder_that_is_read_is_an_output)
{
    char *store = iso_path_join(folder, "store"), *link = iso_path_join(folder, "way");
    char *deep = iso_path_join(store, "0"), *beside = iso_path_join(folder, "store.iso");
    assert_int_equal(mkdir(store, 0700) + mkdir(deep, 0700) + symlink(store, link), 0);
    char *chunk = iso_path_join(deep, "0.0.0"), *early = make_file("store/early"), *other = iso_path_join(link, "new");
    assert_ok(iso_inputs_note_folder(deep, &err));
    assert_ok(iso_inputs_announce(early, &err));
    assert_status(iso_inputs_announce(chunk, &err), ISO_E_USAGE);
    assert_ok(iso_inputs_check(other, &err));
    assert_status(iso_inputs_note_folder(store, &err), ISO_E_USAGE);
    assert_status(iso_inputs_check(other, &err), ISO_E_USAGE);
    assert_ok(iso_inputs_check(beside, &err));
    char *const all[] = {store, link, deep, beside, chunk, early, other};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        free(all[i]);
}

TEST(what_is_not_there_is_neither)
{
    FREED char *path = iso_path_join(folder, "nothing");
    assert_ok(iso_inputs_announce(path, &err));
    assert_ok(iso_inputs_note(path, &err));
    assert_ok(iso_inputs_note(folder, &err));
    assert_ok(iso_inputs_check(path, &err));
}

/* What a command writes and reads again, such as a scene beside a report. */
TEST(an_output_that_was_written_may_be_read)
{
    FREED char *path = make_file("d");
    assert_ok(iso_inputs_announce(path, &err));
    assert_ok(iso_file_write(path, "new", 3, &err));
    assert_ok(iso_inputs_note(path, &err));
}

TEST(a_folder_is_not_replaced_where_a_file_of_it_is_read)
{
    iso_output out;
    FREED char *path = iso_path_join(folder, "dir"), *file = iso_path_join(path, "marker");
    for (int run = 0; run < 2; ++run) { /* the second replaces the first */
        assert_ok(iso_output_begin_dir(&out, path, "marker", &err));
        FREED char *inside = iso_path_join(out.temp_path, "marker");
        assert_ok(iso_file_write(inside, "", 0, &err));
        assert_ok(iso_output_commit(&out, &err));
    }
    assert_ok(iso_inputs_note(file, &err));
    assert_status(iso_output_begin_dir(&out, path, "marker", &err), ISO_E_USAGE);
}

TEST(threads_note_at_once)
{
    enum { FILES = 64, ROUNDS = 16 };
    char *paths[FILES];
    for (int i = 0; i < FILES; ++i) {
        char name[16];
        snprintf(name, sizeof name, "t%d", i);
        paths[i] = make_file(name);
    }
    size_t failed = 0;
#pragma omp parallel for num_threads(4) reduction(+ : failed)
    for (int i = 0; i < FILES * ROUNDS; ++i)
        failed += iso_inputs_note(paths[i % FILES], NULL) != ISO_OK;
    assert_int_equal(failed, 0);
    for (int i = 0; i < FILES; ++i) {
        assert_status(iso_inputs_check(paths[i], &err), ISO_E_USAGE);
        free(paths[i]);
    }
}

TEST_MAIN(make_folder, remove_folder)
