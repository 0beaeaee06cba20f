/* SPDX-License-Identifier: MIT */
/* xml.h - reading small XML files by libxml2, with errors that name the file, the element and the attribute. Nothing is
 * fetched, and no entity is replaced. */
#ifndef ISO_TF_XML_H
#define ISO_TF_XML_H

#include <libxml/tree.h>
#include <stdbool.h>

#include "tf/format.h"

/* To be freed by xmlFreeDoc(). ISO_E_FORMAT with the line. */
iso_status iso_xml_parse(const iso_tf_file *file, xmlDocPtr *doc, iso_error *err);

bool iso_xml_is(const xmlNode *node, const char *name);
/* The next element of that name in the order of the file, at any depth, behind `from`, which may be the document's root;
 * NULL: there is none below `top`. */
xmlNode *iso_xml_next(const xmlNode *top, const xmlNode *from, const char *name);
/* The first element of that name right below the node. NULL: none. */
xmlNode *iso_xml_child(const xmlNode *node, const char *name);
/* To be freed by xmlFree(); NULL: it has none. */
char *iso_xml_text(const xmlNode *node, const char *attribute);
/* A number in [lo, hi]. ISO_E_FORMAT: missing, or no number; ISO_E_RANGE. */
iso_status iso_xml_number(const iso_tf_file *file, const xmlNode *node, const char *attribute, const double limits[2],
                          double *value, iso_error *err);
/* A value that is left out keeps what it was. */
iso_status iso_xml_optional_number(const iso_tf_file *file, const xmlNode *node, const char *attribute,
                                   const double limits[2], double *value, iso_error *err);

extern const double iso_xml_any[2], iso_xml_fraction[2], iso_xml_byte[2]; /* limits */

#endif
