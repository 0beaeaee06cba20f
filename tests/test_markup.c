/* SPDX-License-Identifier: MIT */
/* Texts in markup come back from a parser as they were, as content and in an attribute of either quote. */
#define _GNU_SOURCE
#include "test.h"

#include <libxml/parser.h>

#include "base/markup.h"
#include "base/random.h"

static char *page_of(const char *text)
{
    char *page = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&page, &size);
    assert_non_null(f);
    fputs("<p a=\"", f);
    iso_markup_put(f, text);
    fputs("\" b='", f);
    iso_markup_put(f, text);
    fputs("'>", f);
    iso_markup_put(f, text);
    fputs("</p>", f);
    fclose(f);
    return page;
}

static void expect_back(const char *text)
{
    FREED char *page = page_of(text);
    xmlDoc *doc = xmlReadMemory(page, (int)strlen(page), NULL, "UTF-8", XML_PARSE_NONET);
    if (!doc)
        fail_msg("no markup: %s", page);
    xmlNode *root = xmlDocGetRootElement(doc);
    xmlChar *found[3] = {xmlGetProp(root, (const xmlChar *)"a"), xmlGetProp(root, (const xmlChar *)"b"),
                         xmlNodeGetContent(root)};
    for (int i = 0; i < 3; ++i) {
        assert_string_equal((const char *)found[i], text);
        xmlFree(found[i]);
    }
    assert_null(root->children ? root->children->next : NULL);
    xmlFreeDoc(doc);
}

TEST(any_text_comes_back)
{
    static const char letters[] = "ab&<>\"'`;=#/-!]x \\$%{}@";
    iso_random random = {11};
    expect_back("x\" onfocus=\"alert(1)");
    expect_back("x' onfocus='alert(1)");
    expect_back("</p><script>alert(1)</script>");
    expect_back("&amp;&#39; \xc3\xa9");
    for (int i = 0; i < 2000; ++i) {
        char text[24];
        const size_t n = (size_t)iso_random_below(&random, sizeof text - 1);
        for (size_t k = 0; k < n; ++k)
            text[k] = letters[iso_random_below(&random, sizeof letters - 1)];
        text[n] = 0;
        expect_back(text);
    }
}

TEST(control_characters_become_spaces)
{
    FREED char *page = page_of("a\033[31m\001b\xc2\x9b\x31m\xc3\x9b");
    assert_non_null(strstr(page, "a [31m b 1m\xc3\x9b"));
    assert_null(strchr(page, '\033'));
    assert_null(strstr(page, "\xc2\x9b"));
}

TEST_MAIN(NULL, NULL)
