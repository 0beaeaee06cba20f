/* SPDX-License-Identifier: MIT */
/* certificate.h - certificates of renderers, made of reports: a page, certificates.json, and a badge per renderer.
 *
 * A certificate is all rows of agreement of one renderer, volume and scene, from one report. If several reports have
 * the same renderer, volume and scene, the newest counts (of equally old ones the last), and the certificate lists the
 * others as superseded.
 *
 * Its verdict is the worst of its rows: differ, refused, agree, not compared. Rows that are not compared do not spoil
 * it. A level agrees if one of its rows agrees and none differs or is refused. */
#pragma once

#include "report/sections.h"

/* Makes the certificates. *site is new; keys as in doc/reference/files-report.md, without command, options and title.
 * ISO_E_FORMAT, with the report: a row without its texts, a name of a renderer that no file can have, or no row. */
iso_status iso_certificates_of(const iso_report_source *reports, size_t count, json_t **site, iso_error *err);

/* Writes DIR/index.html with all pictures, DIR/certificates.json and DIR/badges/RENDERER.svg; an existing DIR is
 * replaced only if it has a certificates.json. ISO_E_IO and others: a picture of a report cannot be read. */
iso_status iso_certificates_write(const char *dir, const json_t *site, const iso_report_source *reports,
                                  iso_error *err);

/* Names levels: "0-2", "0, 2". levels: objects with "level", ascending, and "verdict"; those that agree. */
enum { ISO_LEVELS_TEXT_BYTES = 64 };
