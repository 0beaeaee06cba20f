/* SPDX-License-Identifier: MIT */
/* A file that a person changed is kept under a name of its own, also if several processes overwrite it at once. */
#define _GNU_SOURCE
#include "test.h"

#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "base/stamp.h"
#include "folder.h"

static void write_text(const char *path, const char *text)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

static bool holds(const char *path, const char *text)
{
    FREED char *data = NULL;
    size_t size = 0;
    const bool is_equal =
        iso_file_read(path, &data, &size, NULL) == ISO_OK && size == strlen(text) && memcmp(data, text, size) == 0;
    return is_equal;
}

TEST(a_stamped_file_is_overwritten)
{
    iso_error err = {""};
    write_text("a.blend", "ours");
    assert_int_equal(iso_stamp_append("a.blend", "// ", &err), ISO_OK);
    assert_int_equal(iso_stamp_guard("a.blend", false, &err), ISO_OK);
    write_text("a.blend", "a person's");
    assert_int_equal(iso_stamp_guard("a.blend", false, &err), ISO_E_IO);
    assert_int_equal(iso_stamp_guard("none.blend", false, &err), ISO_OK);
}

TEST(no_backup_replaces_another)
{
    iso_error err = {""};
    write_text("b.blend1", "first");
    write_text("b.blend2", "second");
    write_text("b.blend", "third");
    assert_int_equal(iso_stamp_guard("b.blend", true, &err), ISO_OK);
    assert_true(holds("b.blend1", "first"));
    assert_true(holds("b.blend2", "second"));
    assert_true(holds("b.blend3", "third"));
}

/* As an export with --force does: guards, then gives the name to its own file. */
static void export_by_force(const char *own)
{
    iso_error err = {""};
    write_text(own, "ours");
    if (iso_stamp_append(own, "// ", &err) != ISO_OK || iso_stamp_guard("c.blend", true, &err) != ISO_OK ||
        rename(own, "c.blend") != 0)
        _exit(1);
    _exit(0);
}

TEST(a_persons_file_survives_three_exports_at_once)
{
    enum { ROUNDS = 50, EXPORTS = 3, BACKUPS = 4 };
    for (int round = 0; round < ROUNDS; ++round) {
        bool is_kept = false;
        write_text("c.blend", "a person's");
        for (int i = 0; i < EXPORTS; ++i) {
            char own[32];
            snprintf(own, sizeof own, "own%d", i);
            if (fork() == 0)
                export_by_force(own);
        }
        for (int i = 0, code; i < EXPORTS; ++i)
            assert_true(wait(&code) > 0 && WIFEXITED(code) && WEXITSTATUS(code) == 0);
        for (int i = 1; i <= BACKUPS; ++i) {
            char name[32];
            snprintf(name, sizeof name, "c.blend%d", i);
            is_kept = is_kept || holds(name, "a person's");
            unlink(name);
        }
        assert_true(is_kept);
    }
}

static int enter_folder(void **state)
{
    return make_folder(state) == 0 ? chdir(folder) : -1;
}

TEST_MAIN(enter_folder, remove_folder)
