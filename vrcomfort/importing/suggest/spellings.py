"""Item names as labs write them beyond what an instrument itself lists: other languages."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from vrcomfort.questionnaire.instruments import Instrument, plain

_SSQ: Mapping[str, str] = {
    "general_discomfort": "allgemeines unwohlsein, unwohlsein, allgemeines unbehagen, "
    "malaise général,"
    " inconfort général, malestar general, incomodidad general, malessere generale, "
    "disagio generale, algemeen onbehagen, mal estar geral, desconforto geral, 全身不适, 一般不适, "
    "整体不适, 全般的な不快感, 気分が悪い, 전반적 불편함",
    "fatigue": "ermüdung, müdigkeit, erschöpfung, fatiga, cansancio, affaticamento, stanchezza, "
    "vermoeidheid, fadiga, cansaço, 疲劳, 疲勞, 疲労感, 疲れ, 피로, tiredness, fatica",
    "headache": "kopfschmerzen, kopfschmerz, mal de tête, maux de tête, céphalée, dolor de cabeza, "
    "cefalea, mal di testa, hoofdpijn, dor de cabeça, 头痛, 頭痛, 두통",
    "eyestrain": "überanstrengte augen, augenbelastung, augenanstrengung, angestrengte augen, "
    "augenermüdung, "
    "fatigue oculaire, fatigue visuelle, vista cansada, fatiga visual, fatiga ocular, "
    "tensión ocular, "
    "affaticamento degli occhi, affaticamento visivo, affaticamento oculare, vermoeide ogen, "
    "fadiga ocular, vista cansada, 眼睛疲劳, 眼疲劳, 眼睛疲勞, 目の疲れ, 眼の疲れ, 눈의 피로",
    "difficulty_focusing": "schwierigkeiten beim scharfsehen, schwierigkeiten zu fokussieren, "
    "probleme beim scharfsehen, schwierigkeiten scharf zu sehen, scharfstellen, "
    "difficulté à faire la mise au point, difficulté d accommodation, difficulté de focalisation, "
    "dificultad para enfocar, dificultad de enfoque, difficoltà a mettere a fuoco, "
    "difficoltà di messa a fuoco, moeite met scherpstellen, moeite met focussen, "
    "dificuldade de foco, dificuldade em focar, 聚焦困难, 对焦困难, 目の焦点が合わせづらい, "
    "焦点が合わせづらい, 초점 맞추기 어려움",
    "increased_salivation": "erhöhter speichelfluss, vermehrter speichelfluss, speichelfluss, "
    "salivation accrue, augmentation de la salivation, hypersalivation, aumento de salivación, "
    "aumento de la salivación, salivación, aumento della salivazione, salivazione, "
    "verhoogde speekselproductie, speekselvloed, salivação, aumento de salivação, 唾液增多, "
    "流口水, "
    "唾液が増える, 唾液の増加, 침 분비 증가",
    "sweating": "schwitzen, schweißausbruch, schweissausbruch, sudation, transpiration, sueurs, "
    "sudoración, sudoracion, sudor, sudorazione, zweten, suor, sudorese, transpiração, 出汗, 流汗, "
    "発汗, 汗をかく, 발한",
    "nausea": "übelkeit, uebelkeit, nausée, nausées, náusea, náuseas, nauseas, misselijkheid, "
    "misselijk, 恶心, 噁心, 吐き気, 메스꺼움",
    "difficulty_concentrating": "konzentrationsschwierigkeiten, konzentrationsprobleme, "
    "schwierigkeiten sich zu konzentrieren, difficulté de concentration, "
    "difficultés de concentration, difficulté à se concentrer, dificultad para concentrarse, "
    "dificultad de concentración, difficoltà di concentrazione, difficoltà a concentrarsi, "
    "concentratieproblemen, moeite met concentreren, dificuldade de concentração, "
    "dificuldade em concentrar, 难以集中注意力, 注意力难以集中, 集中困難, 集中しづらい, 집중 곤란",
    "fullness_of_head": "kopfdruck, druck im kopf, druckgefühl im kopf, völlegefühl im kopf, "
    "voller kopf, "
    "tête lourde, lourdeur de tête, pesadez de cabeza, cabeza pesada, presión en la cabeza, "
    "testa pesante, pesantezza di testa, zwaar hoofd, vol gevoel in het hoofd, cabeça pesada, "
    "pressão na cabeça, 头胀, 头部胀满, 頭重感, 頭が重い, 머리가 무거움, fullness of heads, "
    "heavy head, head pressure",
    "blurred_vision": "verschwommenes sehen, verschwommene sicht, unscharfes sehen, vision floue, "
    "vision trouble, visión borrosa, vision borrosa, visione offuscata, vista offuscata, "
    "wazig zien, visão turva, visão embaçada, 视力模糊, 視力模糊, 视觉模糊, 目がかすむ, "
    "視界がぼやける, "
    "흐린 시야",
    "dizzy_eyes_open": "schwindel bei geöffneten augen, schwindel mit offenen augen, "
    "schwindel augen offen, schwindel offene augen, schwindel bei offenen augen, vertige yeux "
    "ouverts, "
    "étourdissement yeux ouverts, vertiges les yeux ouverts, mareo con los ojos abiertos, "
    "mareo ojos abiertos, "
    "vertigini con gli occhi aperti, vertigini a occhi aperti, capogiro a occhi aperti, "
    "duizelig met ogen open, duizeligheid ogen open, tontura com os olhos abertos, "
    "tontura olhos abertos, 睁眼头晕, 睁眼时头晕, 開眼時のめまい, 目を開けたときのめまい, "
    "눈 뜬 상태 어지러움",
    "dizzy_eyes_closed": "schwindel bei geschlossenen augen, schwindel mit geschlossenen augen, "
    "schwindel augen geschlossen, schwindel geschlossene augen, schwindel augen zu, "
    "vertige yeux fermés, "
    "étourdissement yeux fermés, vertiges les yeux fermés, mareo con los ojos cerrados, "
    "mareo ojos cerrados, vertigini con gli occhi chiusi, vertigini a occhi chiusi, "
    "capogiro a occhi chiusi, duizelig met ogen dicht, duizeligheid ogen dicht, "
    "tontura com os olhos fechados, tontura olhos fechados, 闭眼头晕, 闭眼时头晕, 閉眼時のめまい, "
    "目を閉じたときのめまい, 눈 감은 상태 어지러움",
    "vertigo": "drehschwindel, gleichgewichtsstörung, schwindelgefühl, schwindel, vertige, "
    "vertiges, "
    "vértigo, vertigine, vertigini, draaiduizeligheid, vertigem, 眩晕, 眩暈, ふらつき, 현기증",
    "stomach_awareness": "magenbewusstsein, magenempfinden, magenbeschwerden, magengefühl, "
    "bewusstsein des magens, auf den magen aufmerksam, "
    "conscience de l estomac, gêne gastrique, inconfort gastrique, "
    "conciencia del estómago, conciencia estomacal, malestar estomacal, molestias estomacales, "
    "consapevolezza dello stomaco, fastidio allo stomaco, maagbewustzijn, bewustzijn van maag, "
    "desconforto abdominal, consciência do estômago, 胃部不适, 胃不适, 胃の存在感, "
    "胃が気になる, 위 불편감",
    "burping": "aufstoßen, aufstossen, rülpsen, éructation, éructations, rots, eructo, eructos, "
    "eructar, eruttazione, eruttazioni, boeren, arroto, arrotos, 打嗝, 嗳气, げっぷ, 트림, "
    "belching, "
    "burp",
}
_BY_INSTRUMENT: Mapping[str, Mapping[str, str]] = {"ssq": _SSQ}


@cache
def _spellings(instrument: Instrument) -> tuple[tuple[str, str], ...]:
    others = _BY_INSTRUMENT.get(instrument.name, _SSQ)
    found: dict[str, str] = {}
    for item in instrument.items:
        for key in item.keys:
            found.setdefault(key, item.name)
    for item in instrument.items:
        for word in others.get(item.name, "").split(","):
            if plain(word):
                found.setdefault(plain(word), item.name)
    return tuple(found.items())


def spellings(instrument: Instrument) -> dict[str, str]:
    """Return spelling (as `plain` writes it) → item."""
    return dict(_spellings(instrument))
