/* SPDX-License-Identifier: MIT */
/* look.h - the options for what a picture shows, alike in every command that takes a scene.
 *
 *     iso_cli_look look = {0};
 *     struct poptOption options[] = {ISO_CLI_LOOK_OPTIONS(&look), ..., POPT_TABLEEND};
 *     ... iso_cli_parse(...), iso_subject_check_look(&request, err) before any work,
 *         where request = iso_cli_look_request(&look, threads) ... */
#ifndef ISO_OPTIONS_LOOK_H
#define ISO_OPTIONS_LOOK_H

#include <popt.h>

#include "scene/subject.h"

typedef struct iso_cli_look {
    char *scene, *tf, *view, *size; /* by popt; live until the process ends */
    double zoom;
} iso_cli_look;

/* clang-format off */
#define ISO_CLI_LOOK_OPTIONS(a)                                                                                             \
    {"scene", 0, POPT_ARG_STRING, &(a)->scene, 0, "camera, lights, shading and transfer function (a first picture of the volume)", "SCENE.scene.json"}, \
    {"tf", 0, POPT_ARG_STRING, &(a)->tf, 0, "transfer function: a file, or a preset of isoshade list (the scene's; auto)", "FILE|PRESET"}, \
    {"view", 0, POPT_ARG_STRING, &(a)->view, 0, "where to look from: a name of isoshade list, or degrees (the scene's; front of a patient, else iso)", "NAME|AZ,EL"}, \
    {"zoom", 0, POPT_ARG_DOUBLE, &(a)->zoom, 0, "enlarge the middle of the picture so many times (1)", "X"},                 \
    {"size", 0, POPT_ARG_STRING, &(a)->size, 0, "image size instead of the scene's, or of 512x512", "WxH"}
/* clang-format on */

static inline iso_subject_look iso_cli_look_request(const iso_cli_look *a, int threads)
{
    return (iso_subject_look){
        .scene = a->scene, .tf = a->tf, .view = a->view, .size = a->size, .zoom = a->zoom, .threads = threads};
}

#endif
