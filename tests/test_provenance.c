/* SPDX-License-Identifier: MIT */
/* Words of command lines in outputs: relative paths stay, so that the command runs again; absolute ones, which name
 * people and machines, keep their last name only. */
#define _GNU_SOURCE
#include "test.h"

#include "base/provenance.h"

static void expect_word(const char *word, const char *expected)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    assert_non_null(f);
    iso_provenance_put_word(f, word);
    fclose(f);
    assert_string_equal(text, expected);
}

TEST(relative_paths_are_kept)
{
    expect_word("in/v.nrrd", "in/v.nrrd");
    expect_word("../in/", "../in/");
    expect_word("--scene=a/x.scene.json,b/y.scene.json", "--scene=a/x.scene.json,b/y.scene.json");
    expect_word("name=out/pictures", "name=out/pictures");
    expect_word("1/255", "1/255");
    expect_word("--steps=1/2,1/4", "--steps=1/2,1/4");
    expect_word("a b/c", "'a b/c'");
}

TEST(absolute_paths_are_shortened)
{
    expect_word("/home/jane/v.nrrd", "v.nrrd");
    expect_word("/home/jane/in/", "in/");
    expect_word("--scene=/home/jane/x.scene.json", "--scene=x.scene.json");
    expect_word("-o/home/jane/x.exr", "-ox.exr");
    expect_word("name=/home/jane/pictures", "name=pictures");
    expect_word("file:///home/jane/v.nrrd", "file:v.nrrd");
    expect_word("a/x.json,/home/jane/y.json,b/z.json", "a/x.json,y.json,b/z.json");
    expect_word("/home/jane/x.json,/home/jane/y.json", "x.json,y.json");
}

TEST(a_path_with_a_comma_leaves_no_folder)
{
    expect_word("/home/jane, doe/x.json", "x.json");
    expect_word("--scene=/home/jane, doe/x.json", "--scene=x.json");
}

TEST(lines_follow_their_words)
{
    FREED char *line = iso_provenance_line("isoshade build in/a.nrrd '/home/jane doe/b.nrrd' && ls");
    assert_string_equal(line, "isoshade build in/a.nrrd b.nrrd && ls");
    assert_string_equal(iso_provenance_path("in/a"), "in/a");
    assert_string_equal(iso_provenance_path("/in/a"), "a");
}

TEST_MAIN(NULL, NULL)
