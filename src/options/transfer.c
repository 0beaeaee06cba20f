/* SPDX-License-Identifier: MIT */
#include "options/transfer.h"

#include <stdlib.h>
#include <string.h>

const iso_option iso_transfer_rows[] = {
    {"name", 0, "transfer function of a file that holds several", "NAME", ISO_IN(iso_cli_transfer, name)},
    {"unit-distance", 0, "length that the opacities are for, if the file lacks it", "MM",
     ISO_IN(iso_cli_transfer, unit_distance)},
    {"opacity", 0, "opacity at both ends of the range, for files of colors only", "A[,B]",
     ISO_IN(iso_cli_transfer, opacity)},
    {"range", 0, "replace the file's range; fit: use the volume's range", "fit|LO,HI", ISO_IN(iso_cli_transfer, range)},
    ISO_OPTIONS_END,
};

/* Reads "A" or "A,B", numbers in [lo, hi]. Returns their count; 0 if the text is neither. */
static int read_pair(const char *text, double lo, double hi, double values[2])
{
    int count = 0;
    for (char *end; count < 2; text = end + 1) {
        values[count] = strtod(text, &end);
        if (end == text || !(values[count] >= lo && values[count] <= hi))
            return 0;
        ++count;
        if (*end == '\0')
            return count;
        if (*end != ',')
            return 0;
    }
    return 0;
}

iso_status iso_cli_transfer_request(const iso_cli_transfer *a, iso_tf_request *q, iso_error *err)
{
    double unit[2] = {0};
    int numbers = 0;
    *q = (iso_tf_request){.name = a->name, .has_opacity = a->opacity, .has_range = a->range};
    if (a->unit_distance && read_pair(a->unit_distance, ISO_TF_LEAST_UNIT, ISO_TF_MOST_UNIT, unit) != 1)
        return iso_fail(err, ISO_E_USAGE, "--unit-distance is \"%s\", must be millimeters, %g to %g", a->unit_distance,
                        ISO_TF_LEAST_UNIT, ISO_TF_MOST_UNIT);
    q->unit_mm = unit[0];
    if (a->opacity && (numbers = read_pair(a->opacity, 0, 1, q->opacity)) == 0)
        return iso_fail(err, ISO_E_USAGE, "--opacity is \"%s\", must be one or two numbers of 0 to 1", a->opacity);
    if (numbers == 1)
        q->opacity[1] = q->opacity[0];
    q->fit = a->range && strcmp(a->range, "fit") == 0;
    if (a->range && !q->fit &&
        (read_pair(a->range, -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE, q->range) != 2 || !(q->range[1] > q->range[0])))
        return iso_fail(err, ISO_E_USAGE, "--range is \"%s\", must be \"fit\" or two rising numbers LO,HI", a->range);
    return ISO_OK;
}
