"""People who sign in at a console with an identity, in a real browser, beside a robot that keeps a policy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.page import confirm, new_context, row, view
from helpers.patience import BROWSER, wait_for
from helpers.processes import Program

from goalwire.security import audit
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb
from goalwire.security.sign_in.tokens import delete_tokens, make_token

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

ALL = ''.join(f'{verb.value} = ["/**"]\n' for verb in Verb)
POLICY = f"""\
[everyone]
publish = ["/rosout", "/parameter_events"]
[roles.robot]
{ALL}
missions = true
[roles.operator]
call = ["/lamp"]
send = ["/go_to"]
cancel = ["/**"]
subscribe = ["/**"]
watch = ["/**"]
read = ["/**"]
introspect = ["/**"]
missions = true
[roles.guest]
[roles.narrow]
stop = false
subscribe = ["/load"]
[identities]
robby = ["robot"]
console = ["robot"]
ann = ["operator"]
ben = ["narrow"]
cy = ["guest"]
"""
SignedIn = Callable[[str], Any]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver and the world live until the module's end; robot and console are processes."""


@pytest.fixture(scope='module')
def keystore(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    made = Keystore.create(tmp_path_factory.mktemp('site') / 'keys')
    made.add('robby', 'robot', ())
    made.add('console', 'program', ())
    made.add('ann', 'person', ())
    made.policy_path.write_text(POLICY)
    return made


@pytest.fixture(scope='module')
def world(keystore: Keystore, journal: Path) -> Iterator[tuple[Program, str]]:
    """The robot, and the address of a console beside it, which shows the missions of `carrier`."""
    pytest.importorskip('nicegui')
    stage = Stage('rmw_zenoh_cpp')
    stage.env['GOALWIRE_SECURITY'] = f'{keystore.path}:robby'
    robot = stage.robot()
    stage.env['GOALWIRE_SECURITY'] = f'{keystore.path}:console'
    yield robot, stage.console('--missions', str(journal))[1]
    stage.close()


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp('missions') / 'missions.db'


@pytest.fixture
def carrier(keystore: Keystore, journal: Path) -> Iterator[Program]:
    """A runner with a mission that asks, and one that was paused."""
    stage = Stage('rmw_zenoh_cpp')
    stage.env['GOALWIRE_SECURITY'] = f'{keystore.path}:robby'
    runner = stage.program(PROGRAMS / 'carrier.py', str(journal))
    runner.expect('^ready$', BROWSER)
    yield runner
    stage.close()


@pytest.fixture
def sign_in(chromium: Any, world: tuple[Program, str], keystore: Keystore) -> Iterator[SignedIn]:
    """`sign_in('ann')` opens the page in a browser of her own, and types her token."""
    contexts = []

    def open_one(name: str) -> Any:
        context = new_context(chromium, 1280, 800)
        contexts.append(context)
        page = context.new_page()
        page.goto(f'{world[1]}?view=services')
        page.fill('#token', make_token(keystore.path, name))
        page.click('button')
        page.wait_for_selector(f'[data-who]:text-is("{name}")')
        assert 'token' not in page.url
        return page

    yield open_one
    for context in contexts:
        context.close()


def _entries(keystore: Keystore) -> list[dict[str, str]]:
    path = audit.log_path(keystore.path, 'console')
    return list(audit.read(path)) if path.exists() else []


def _wait_for_entry(keystore: Keystore, **fields: str) -> None:
    wait_for(
        lambda: any(fields.items() <= entry.items() for entry in _entries(keystore)),
        f'an entry of the audit log with {fields}',
    )


def test_nobody_gets_in_without_a_token_that_counts(world: tuple[Program, str], window: Any) -> None:
    page = window.new_page()
    answer = page.goto(world[1])
    assert answer.status == 401
    page.fill('#token', 'guessed')
    page.click('button')
    page.wait_for_selector('[data-why]:has-text("the token is not known here")')
    picture(page, 'sign-in')
    page.close()


def test_each_person_does_what_the_policy_allows_and_the_log_has_the_name(
    world: tuple[Program, str], sign_in: SignedIn, keystore: Keystore
) -> None:
    robot, _ = world
    page = sign_in('ann')
    view(page, 'services')
    row(page, '/lamp')
    page.click('[data-call]:not([disabled])')
    confirm(page)
    robot.expect('lamp False')
    page.wait_for_selector('.gw-live-table td:has-text("ann"), td:has-text("ann")')
    _wait_for_entry(keystore, who='ann', act='call', key='/lamp', outcome='done', via='console')

    # The controls that she may not use are there, and say why.
    row(page, '/shy')
    page.wait_for_selector('[data-call][disabled]')
    page.wait_for_selector("[data-refused]:has-text(\"none of the roles of 'ann' may call '/shy'\")")
    picture(page, 'refused')
    view(page, 'topics')
    row(page, '/say')
    page.wait_for_selector('[data-open-publish][disabled][data-why*="may publish \'/say\'"]')
    view(page, 'parameters')
    row(page, '/robot')
    page.wait_for_selector('[data-parameter=speed][disabled]')

    # Everybody sees on /rosout who does what.
    view(page, 'logs')
    page.wait_for_selector('td:has-text("ann: call /lamp")')

    # Goals move: they are in the log with what was sent.
    view(page, 'actions')
    row(page, '/go_to')
    page.click('[data-send-goal]:not([disabled])')
    confirm(page)
    _wait_for_entry(keystore, who='ann', act='send', key='/go_to', outcome='moves')


def test_who_may_see_little_sees_little_and_cannot_stop(sign_in: SignedIn, keystore: Keystore) -> None:
    page = sign_in('ben')
    view(page, 'topics')
    page.wait_for_selector('tr[data-key="/load"]')
    assert page.locator('tr[data-key="/battery"]').count() == 0
    view(page, 'logs')
    page.wait_for_selector('[data-refused]:has-text("may subscribe \'/rosout\'")')
    page.wait_for_selector('[data-no-estop][title*="narrow: stop = false"]')
    page.keyboard.press('Pause')
    page.wait_for_selector('[data-stop-report=failed]:has-text("stop = false")')
    _wait_for_entry(keystore, who='ben', act='stop', outcome='was refused', key='/estop')

    # A press that comes as a request alone needs the same right.
    answer = page.evaluate("""async () => {
      const body = JSON.stringify({ press: 'by hand', robot: '', all: true });
      return await (await fetch('/console/stop', { method: 'POST', body })).text(); }""")
    assert '"ok": false' in answer
    assert 'stop = false' in answer


@pytest.mark.long
def test_missions_go_on_by_those_whom_the_policy_allows_it_and_others_can_stop_them(
    sign_in: SignedIn, keystore: Keystore, carrier: Program
) -> None:
    """In each run test_mission_journal.py has all that people may say to a mission, without a browser."""
    # Ben may not even stop: all his buttons are disabled, and say why.
    page = sign_in('ben')
    view(page, 'missions')
    nobody = '[disabled][data-why*="none of the roles of \'ben\' has missions = true"]'
    for mission, word in (('asks', 'yes'), ('asks', 'no'), ('paused', 'resume'), ('paused', 'undo')):
        page.wait_for_selector(f'[data-question={mission}] [data-say={word}]{nobody}')
    page.wait_for_selector('[data-question=paused] [data-say=cancel][disabled][data-why*="stop = false"]')

    # Cy has no right at all, and that is enough to stop a mission.
    page = sign_in('cy')
    view(page, 'missions')
    page.wait_for_selector('[data-question=paused] [data-say=resume][disabled]')
    picture(page, 'missions-refused')
    page.click('[data-question=paused] [data-say=cancel]:not([disabled])')
    carrier.expect('^paused canceled cy cancelled it', BROWSER)
    _wait_for_entry(keystore, who='cy', act='cancel', key='mission wait paused', outcome='stops')

    page = sign_in('ann')
    view(page, 'missions')
    page.click('[data-question=asks] [data-say=yes]:not([disabled])')
    carrier.expect('^asks succeeded .*ann$', BROWSER)
    _wait_for_entry(keystore, who='ann', act='approve', key='mission carry asks', what='yes', outcome='moves')
    view(page, 'logs')
    page.wait_for_selector('td:has-text("cy: cancel mission wait paused")')
    page.wait_for_selector('td:has-text("ann: approve mission carry asks: yes")')


def test_a_page_ends_with_its_token(sign_in: SignedIn, keystore: Keystore) -> None:
    page = sign_in('ben')
    delete_tokens(keystore.path, 'ben')
    page.wait_for_selector('#token')


def test_signing_out_forgets_the_token(sign_in: SignedIn) -> None:
    page = sign_in('ann')
    page.click('[data-sign-out]')
    page.wait_for_selector('#token')
    page.reload()
    page.wait_for_selector('#token')


def test_who_has_signed_in_may_stop_without_any_right_to_call_it(
    world: tuple[Program, str], sign_in: SignedIn, keystore: Keystore
) -> None:
    robot, _ = world
    page = sign_in('ann')
    page.click('[data-estop]')
    robot.expect('^stopped')
    page.wait_for_selector('[data-stop-report=stopped]')
    _wait_for_entry(keystore, who='ann', act='stop', outcome='stops', key='/estop')


def test_a_certificate_of_the_keystore_signs_in_without_a_token(
    chromium: Any, keystore: Keystore, tmp_path: Path
) -> None:
    own = keystore.identity_path('console')
    stage = Stage('rmw_zenoh_cpp')
    stage.env['GOALWIRE_SECURITY'] = f'{keystore.path}:console'
    try:
        _, url = stage.console('--tls-cert', str(own), '--tls-key', str(own))
        origin = url.rstrip('/')
        shown = [
            {
                'origin': origin,
                'cert': b''.join(each.public_bytes(_pem()) for each in keystore.identity('ann').chain[:1]),
                'key': keystore.identity_path('ann').read_bytes(),
            }
        ]
        for certificates, found in (([], '#token'), (shown, '[data-who]:text-is("ann")')):
            context = new_context(
                chromium, 1280, 800, ignore_https_errors=True, client_certificates=certificates
            )
            page = context.new_page()
            page.goto(url)
            page.wait_for_selector(found)
            context.close()
    finally:
        stage.close()


def _pem() -> Any:
    from cryptography.hazmat.primitives.serialization import Encoding

    return Encoding.PEM
