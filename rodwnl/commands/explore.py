"""`rodwnl explore`: a page on this machine, with sliders for the rod."""

from typing import Annotated

import typer

from rodwnl.errors import InputError
from rodwnl.options import Model, Parameter, read_model


def command(
    port: Annotated[int, typer.Option(metavar="N", help="Port on 127.0.0.1. Default: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
    model: Model = None,
    parameter: Parameter = None,
) -> None:
    """Change a rod with sliders and see spectrum, mode, coefficients and amplitudes follow, in the browser.

    With --model the parameters that only this rod has get sliders too; --parameter says where those begin.
    The server answers on this machine only, and the page fetches nothing from elsewhere. Ctrl-C ends it.
    """
    if not 0 <= port <= 65535:
        raise InputError(f"--port is {port}, but it must lie between 0 and 65535")
    from rodwnl.explore.server import serve
    from rodwnl.parameters import PLAIN, own_values

    values = read_model(model, parameter or [])
    name = values.pop("model", PLAIN)
    server = serve(port, name, own_values(name, values))
    with server:
        host, number = server.server_address[:2]
        address = f"http://{host!s}:{number}/"
        print(f"{address} (Ctrl-C ends it)", flush=True)
        if browser:
            import webbrowser

            webbrowser.open(address)
        server.serve_forever()
