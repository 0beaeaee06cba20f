/* SPDX-License-Identifier: MIT */
/* Each input changes the key, by the part that is named after it, and nothing else does. */
#define _GNU_SOURCE
#include "test.h"

#include <fcntl.h>
#include <jansson.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/key.h"

/* Temporaries of this process, as those of test.h are, are no inputs. */
static char folder[64];

static int make_folder(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/key-XXXXXX");
    iso_inputs_watch();
    return mkdtemp(folder) && setenv("HOME", folder, 1) == 0 ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    iso_remove_tree(folder);
    return 0;
}

static char *path_of(const char *name)
{
    char *path = iso_path_join(folder, name);
    assert_non_null(path);
    return path;
}

/* As another program: ours writes over no input. */
static void write_text(const char *name, const char *text)
{
    FREED char *path = path_of(name);
    FILE *f = fopen(path, "w");
    assert_true(f && fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

/* The same inode, size and time of the last change of its content. */
static void overwrite_in_place(const char *name, off_t at, const char *text)
{
    FREED char *path = path_of(name);
    struct stat st;
    const int fd = open(path, O_WRONLY);
    assert_true(fd >= 0 && fstat(fd, &st) == 0);
    assert_int_equal(pwrite(fd, text, strlen(text), at), strlen(text));
    assert_int_equal(futimens(fd, (const struct timespec[]){st.st_atim, st.st_mtim}), 0);
    close(fd);
}

static void note(const char *name)
{
    FREED char *path = path_of(name);
    assert_ok(iso_path_is_dir(path) ? iso_inputs_note_folder(path, &err) : iso_inputs_note(path, &err));
}

static iso_key *make_key(void)
{
    iso_key *key = iso_key_create();
    assert_non_null(key);
    iso_key_add_text(key, "--frame", getenv("FRAME"));
    assert_ok(iso_key_add_dependency(key, "./renderer", &err));
    assert_ok(iso_key_add_dependency(key, "~/renderer.ini", &err));
    assert_ok(iso_key_add_surroundings(key, &err));
    return key;
}

static void change_option(void)
{
    setenv("FRAME", "1", 1);
}
static void change_file(void)
{
    overwrite_in_place("v.raw", 3, "X");
}
static void change_large_file(void)
{
    overwrite_in_place("large.raw", 70000, "X");
} /* between two samples */
static void change_chunk(void)
{
    overwrite_in_place("v.zarr/0.0", 0, "X");
}
static void add_chunk(void)
{
    write_text("v.zarr/0.1", "");
}
static void rename_chunk(void)
{
    FREED char *from = path_of("v.zarr/0.1"), *to = path_of("v.zarr/1.0");
    assert_int_equal(rename(from, to), 0);
}
static void change_variable(void)
{
    setenv("LIBGL_ALWAYS_SOFTWARE", "2", 1);
}
static void add_variable(void)
{
    setenv("POVINI", "/nowhere", 1);
}
static void change_renderer(void)
{
    overwrite_in_place("renderer", 10, "X");
}
static void add_settings(void)
{
    write_text("renderer.ini", "Quality=1\n");
}

/* The last is the same in each key of a process. */
static const struct {
    const char *part; /* or its beginning */
    const char *told;
    void (*change)(void);
} rows[] = {
    {"--frame", "--frame is not the same", change_option},
    {"input ", "v.raw changed since", change_file},
    {"input ", "large.raw changed since", change_large_file},
    {"input ", "v.zarr changed since", change_chunk},
    {"input ", "v.zarr changed since", add_chunk},
    {"input ", "v.zarr changed since", rename_chunk},
    {"$LIBGL_ALWAYS_SOFTWARE", "$LIBGL_ALWAYS_SOFTWARE is not the same", change_variable},
    {"$POVINI", "$POVINI is not the same", add_variable},
    {"./renderer", "./renderer is not the same", change_renderer},
    {"~/renderer.ini", "~/renderer.ini is not the same", add_settings},
};

static void make_inputs(void)
{
    char *zarr = path_of("v.zarr"), *large = path_of("large.raw");
    assert_int_equal(mkdir(zarr, 0777), 0);
    write_text("v.raw", "abcdefgh");
    write_text("v.zarr/0.0", "chunk");
    write_text("renderer", "#!/bin/sh\nexec true\n");
    write_text("large.raw", "begins");
    assert_int_equal(truncate(large, (off_t)ISO_KEY_WHOLE_BYTES + 1), 0); /* it takes no room */
    free(zarr);
    free(large);
    note("v.raw");
    note("large.raw");
    note("v.zarr");
    setenv("FRAME", "0", 1);
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    unsetenv("POVINI");
    assert_int_equal(chdir(folder), 0);
}

/* The stored parts, with the new values of those that are named: as if these inputs were left out. */
static void leave_out(json_t *stored, const json_t *now, const char *part)
{
    const char *name;
    json_t *value;
    json_object_foreach((json_t *)now, name, value) if (strncmp(name, part, strlen(part)) == 0)
        json_object_set(stored, name, value);
}

TEST(each_input_changes_its_own_part_alone)
{
    char why[256], before[ISO_KEY_DIGEST_BYTES], after[ISO_KEY_DIGEST_BYTES];
    make_inputs();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        iso_key *key = make_key(), *again = make_key();
        json_auto_t *stored = iso_key_to_json(key);
        assert_true(iso_key_digest(key, before) && iso_key_digest(again, after));
        assert_string_equal(before, after);
        assert_false(iso_key_differs(again, stored, why, sizeof why));
        rows[i].change();
        iso_key *now = make_key();
        json_auto_t *parts = iso_key_to_json(now);
        assert_true(iso_key_digest(now, after));
        if (strcmp(before, after) == 0 || !iso_key_differs(now, stored, why, sizeof why))
            fail_msg("the change of \"%s\" was not noticed", rows[i].part);
        if (!strstr(why, rows[i].told))
            fail_msg("\"%s\" is said of a change of \"%s\"", why, rows[i].part);
        leave_out(stored, parts, rows[i].part); /* planted fault: a key without the part */
        assert_false(iso_key_differs(now, stored, why, sizeof why));
        iso_key_destroy(now);
        iso_key_destroy(again);
        iso_key_destroy(key);
    }
}

TEST(a_file_that_is_touched_or_written_again_is_the_same)
{
    char why[256];
    iso_key *key = make_key();
    json_auto_t *stored = iso_key_to_json(key);
    FREED char *path = path_of("v.raw");
    unlink(path);
    write_text("v.raw", "abcXefgh"); /* perhaps another inode, the same bytes */
    iso_key *now = make_key();
    assert_false(iso_key_differs(now, stored, why, sizeof why));
    iso_key_destroy(now);
    iso_key_destroy(key);
}

TEST(an_input_more_or_less_is_noticed)
{
    char why[256];
    iso_key *key = make_key();
    json_auto_t *stored = iso_key_to_json(key);
    write_text("w.raw", "w");
    note("w.raw");
    iso_key *now = make_key();
    json_auto_t *parts = iso_key_to_json(now);
    assert_true(iso_key_differs(now, stored, why, sizeof why));
    assert_non_null(strstr(why, "other files are read"));
    assert_true(iso_key_differs(key, parts, why, sizeof why));
    assert_true(iso_key_differs(key, NULL, why, sizeof why)); /* no key was stored */
    iso_key_destroy(now);
    iso_key_destroy(key);
}

TEST(an_input_that_is_gone_is_an_error)
{
    FREED char *path = path_of("w.raw");
    unlink(path);
    iso_key *key = iso_key_create();
    iso_error why = {""};
    assert_int_equal(iso_key_add_surroundings(key, &why), ISO_E_IO);
    assert_non_null(strstr(why.text, "w.raw: cannot be read"));
    iso_key_destroy(key);
}

TEST(values_and_paths_are_not_readable)
{
    iso_key *key = iso_key_create();
    iso_key_add_text(key, "--scene", "/home/somebody/secret.scene.json");
    json_auto_t *parts = iso_key_to_json(key);
    FREED char *text = json_dumps(parts, 0);
    assert_null(strstr(text, "secret"));
    iso_key_destroy(key);
}

TEST_MAIN(make_folder, remove_folder)
