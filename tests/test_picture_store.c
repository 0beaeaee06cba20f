/* SPDX-License-Identifier: MIT */
/* The folder of pictures: removed so that a run that is killed in between leaves one that the next run takes. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "folder.h"
#include "renderers/picture_store.h"
#include "test.h"

/* After so many removals the process ends, as if it was killed. Below 0: never. */
static int removals_left = -1;

static void count_removal(void)
{
    if (removals_left == 0)
        _exit(0);
    removals_left -= removals_left > 0;
}

int unlinkat(int dir, const char *name, int flags)
{
    count_removal();
    return (int)syscall(SYS_unlinkat, dir, name, flags);
}

int unlink(const char *path)
{
    count_removal();
    return (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0);
}

int rmdir(const char *path)
{
    count_removal();
    return (int)syscall(SYS_unlinkat, AT_FDCWD, path, AT_REMOVEDIR);
}

enum { PICTURES = 5 };

static void put_pictures(const char *work)
{
    for (int i = 0; i < PICTURES; ++i) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%032x.picture", work, i);
        assert_ok(iso_file_write(path, "x", 1, &err));
    }
}

static void open_store(const char *work, bool keep, iso_picture_store **store)
{
    iso_key *key = iso_key_create();
    assert_non_null(key);
    assert_ok(iso_picture_store_open(work, store, &err));
    assert_ok(iso_picture_store_begin(*store, keep, key, &err));
    iso_key_destroy(key);
}

/* How many removals there are is not assumed: one more each time, until all were made. */
TEST(killed_at_any_removal_it_blocks_no_later_run)
{
    for (int keeps = 0; keeps < 2; ++keeps) {
        FREED char *work = iso_path_join(folder, "r.work");
        bool is_gone = false;
        int kills = 0;
        for (; !is_gone; ++kills) {
            iso_picture_store *store;
            open_store(work, true, &store);
            put_pictures(work);
            const pid_t child = fork();
            if (child == 0) {
                removals_left = kills;
                iso_picture_store_close(store, true);
                _exit(0);
            }
            assert_int_equal(waitpid(child, NULL, 0), child);
            is_gone = !iso_path_exists(work);
            iso_picture_store_close(store, false);
            open_store(work, keeps, &store);
            iso_picture_store_close(store, true);
            assert_false(iso_path_exists(work));
        }
        assert_true(kills > PICTURES + 2); /* with the marker and the folder */
    }
}

TEST_MAIN(make_folder, remove_folder)
