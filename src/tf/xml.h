/* SPDX-License-Identifier: MIT */
/* xml.h - reading of small XML files by libxml2, with errors that name the file, the element and the attribute. Fetches
 * nothing and replaces no entities. */
#pragma once

#include <libxml/tree.h>
#include <stdbool.h>

#include "tf/format.h"

/* Parses a file; *doc is ENDED_BY(iso_xml_free_doc). ISO_E_FORMAT names the line. */
iso_status iso_xml_parse(const iso_tf_file *file, xmlDocPtr *doc, iso_error *err);
void iso_xml_free_doc(xmlDocPtr *doc);

bool iso_xml_is(const xmlNode *node, const char *name);
/* Returns the next element of that name after `from` in the order of the file, at any depth below `top`; NULL: none.
 * from may be the document's root. */
xmlNode *iso_xml_next(const xmlNode *top, const xmlNode *from, const char *name);
/* Finds the element of that name, the root or below it, whose attribute "name" the request gives (iso_tf_choose()). */
iso_status iso_xml_choose(const iso_tf_file *file, const xmlNode *root, const char *element, const char *what,
                          const xmlNode **chosen, iso_error *err);
/* Returns the first child element of that name; NULL: none. */
xmlNode *iso_xml_child(const xmlNode *node, const char *name);
/* Returns the attribute, ENDED_BY(iso_xml_free_text); NULL: none. */
char *iso_xml_text(const xmlNode *node, const char *attribute);
void iso_xml_free_text(char **text);
/* Reads a number in [lo, hi]. ISO_E_FORMAT: missing or not a number; ISO_E_RANGE. */
iso_status iso_xml_number(const iso_tf_file *file, const xmlNode *node, const char *attribute, const double limits[2],
                          double *value, iso_error *err);
/* Does the same, but a missing attribute leaves *value unchanged. */
iso_status iso_xml_optional_number(const iso_tf_file *file, const xmlNode *node, const char *attribute,
                                   const double limits[2], double *value, iso_error *err);

extern const double iso_xml_any[2], iso_xml_fraction[2], iso_xml_byte[2]; /* limits */
