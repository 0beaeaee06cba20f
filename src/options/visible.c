/* SPDX-License-Identifier: MIT */
#include "options/visible.h"

bool iso_cli_warn_visible(const iso_cli *cli, const iso_visible *visible)
{
    char text[1024];
    if (!iso_visible_complaint(visible, cli->arguments[0], text, sizeof text))
        return false;
    iso_progress_line_hide(cli->progress);
    fprintf(stderr, "isoshade %s: warning: %s\n", cli->command->name, text);
    return true;
}

iso_visible iso_cli_warn_view(const iso_cli *cli, const iso_pyramid *p, const iso_view *view, const double *isosurface,
                              bool *warned)
{
    const iso_visible v = iso_visible_measure(iso_pyramid_finest(p), view, isosurface, cli->threads);
    *warned = iso_cli_warn_visible(cli, &v);
    return v;
}

json_t *iso_cli_visible_json(const iso_visible *v)
{
    return json_pack("{s:f, s:f, s:f}", "voxels", v->voxels, "faces", v->faces, "picture", v->picture);
}
