/* SPDX-License-Identifier: MIT */
#include "tf/xml.h"

#include <libxml/parser.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

const double iso_xml_any[2] = {-ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE}, iso_xml_fraction[2] = {0, 1},
             iso_xml_byte[2] = {0, 255};

iso_status iso_xml_parse(const iso_tf_file *file, xmlDocPtr *doc, iso_error *err)
{
    *doc = NULL;
    if (file->size > INT_MAX)
        return iso_fail(err, ISO_E_RANGE, "%s: file is too large for a transfer function", file->path);
    xmlParserCtxtPtr context = xmlNewParserCtxt();
    NEED_MEMORY(context, err, "%s: out of memory", file->path);
    *doc = xmlCtxtReadMemory(context, file->text, (int)file->size, NULL, NULL,
                             XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING);
    iso_status status = ISO_OK;
    if (!*doc) {
        const xmlError *e = xmlCtxtGetLastError(context);
        const char *message = e && e->message ? e->message : "empty file";
        status = iso_fail(err, ISO_E_FORMAT, "%s:%d: not XML: %.*s", file->path, e ? e->line : 0,
                          (int)strcspn(message, "\n"), message);
    } else if (!xmlDocGetRootElement(*doc)) {
        status = iso_fail(err, ISO_E_FORMAT, "%s: has no element", file->path);
    }
    xmlFreeParserCtxt(context);
    return status;
}

void iso_xml_free_doc(xmlDocPtr *doc)
{
    xmlFreeDoc(*doc);
}

bool iso_xml_is(const xmlNode *node, const char *name)
{
    return node->type == XML_ELEMENT_NODE && strcmp((const char *)node->name, name) == 0;
}

/* Returns the next node in the order of the file. */
static const xmlNode *following(const xmlNode *top, const xmlNode *node)
{
    if (node->type == XML_ELEMENT_NODE && node->children)
        return node->children;
    while (node != top && !node->next)
        node = node->parent;
    return node == top ? NULL : node->next;
}

xmlNode *iso_xml_next(const xmlNode *top, const xmlNode *from, const char *name)
{
    for (const xmlNode *node = following(top, from); node; node = following(top, node))
        if (iso_xml_is(node, name))
            return (xmlNode *)node;
    return NULL;
}

xmlNode *iso_xml_child(const xmlNode *node, const char *name)
{
    for (xmlNode *child = node ? node->children : NULL; child; child = child->next)
        if (iso_xml_is(child, name))
            return child;
    return NULL;
}

enum { MOST_CHOICES = 1024 };

iso_status iso_xml_choose(const iso_tf_file *file, const xmlNode *root, const char *element, const char *what,
                          const xmlNode **chosen, iso_error *err)
{
    const xmlNode *nodes[MOST_CHOICES] = {0};
    char *names[MOST_CHOICES] = {0};
    size_t count = 0, at = 0;
    const xmlNode *node = iso_xml_is(root, element) ? root : iso_xml_next(root, root, element);
    for (; node && count < MOST_CHOICES; node = iso_xml_next(root, node, element)) {
        nodes[count] = node;
        names[count] = iso_xml_text(node, "name");
        if (!names[count])
            names[count] = (char *)xmlStrdup((const xmlChar *)"");
        ++count;
    }
    const iso_status status = iso_tf_choose(file, what, (const char *const *)names, count, &at, err);
    *chosen = status == ISO_OK ? nodes[at] : NULL;
    for (size_t i = 0; i < count; ++i)
        xmlFree(names[i]);
    return status;
}

char *iso_xml_text(const xmlNode *node, const char *attribute)
{
    return node ? (char *)xmlGetProp((xmlNode *)node, (const xmlChar *)attribute) : NULL;
}

void iso_xml_free_text(char **text)
{
    xmlFree(*text);
}

iso_status iso_xml_number(const iso_tf_file *file, const xmlNode *node, const char *attribute, const double limits[2],
                          double *value, iso_error *err)
{
    ENDED_BY(iso_xml_free_text) char *text = iso_xml_text(node, attribute);
    const long line = xmlGetLineNo((xmlNode *)node);
    char *end;
    if (!text)
        return iso_fail(err, ISO_E_FORMAT, "%s:%ld: <%s> has no attribute \"%s\"", file->path, line,
                        (const char *)node->name, attribute);
    const double number = strtod(text, &end);
    if (end == text || end[strspn(end, " \t\r\n")] != '\0')
        return iso_fail(err, ISO_E_FORMAT, "%s:%ld: <%s %s=\"%.40s\">: is not a number", file->path, line,
                        (const char *)node->name, attribute, text);
    if (!(number >= limits[0] && number <= limits[1]))
        return iso_fail(err, ISO_E_RANGE, "%s:%ld: <%s %s=\"%g\">: must be %g to %g", file->path, line,
                        (const char *)node->name, attribute, number, limits[0], limits[1]);
    *value = number;
    return ISO_OK;
}

iso_status iso_xml_optional_number(const iso_tf_file *file, const xmlNode *node, const char *attribute,
                                   const double limits[2], double *value, iso_error *err)
{
    if (!node || !xmlHasProp((xmlNode *)node, (const xmlChar *)attribute))
        return ISO_OK;
    return iso_xml_number(file, node, attribute, limits, value, err);
}
